//! Settings of the simulated controller.

use std::collections::BTreeMap;

/// Settings by number, formatted as in answers to `$$`.
pub(crate) type Settings = BTreeMap<u16, String>;

/// Factory settings of a grblHAL with four axes.
const FACTORY: &str = "0=5.0 1=25 2=0 3=0 4=15 5=0 6=0 9=1 10=511 11=0.010 12=0.002 13=0 14=0 15=0 \
                       17=0 18=0 19=0 20=0 21=0 22=0 23=0 24=25.0 25=500.0 26=250 27=1.000 \
                       28=0.100 29=0.0 30=1000.000 31=0.000 32=0 33=5000.0 34=0.0 35=0.0 36=100.0 \
                       37=0 39=1 40=0 41=0 42=2 43=1 44=4 45=3 46=0 47=0 56=5.0 57=100.0 58=-5.0 \
                       59=500.0 60=0 61=0 62=0 63=3 64=0 65=0 100=250.00000 101=250.00000 \
                       102=250.00000 103=250.00000 110=500.000 111=500.000 112=500.000 113=500.000 \
                       120=10.000 121=10.000 122=10.000 123=10.000 130=200.000 131=200.000 \
                       132=200.000 133=200.000 341=0 342=30.0 343=25.0 344=200.0 345=200.0 346=1 \
                       376=1 384=0 392=4.0 393=1.0 394=0.0 398=100 481=0 485=0 486=0 538=0 539=0.0 \
                       673=0.0 676=15 680=0 701=0";

/// Changes for the robot: four linear axes that home downwards, all at once.
const ROBOT: &str = "1=255 10=2047 20=1 21=1 22=13 23=15 24=60.0 25=600.0 27=2.000 44=15 45=0 \
                     100=400.00000 101=400.00000 102=400.00000 103=400.00000 110=600.000 \
                     111=600.000 112=600.000 113=600.000 120=50.000 121=50.000 122=50.000 \
                     123=50.000 130=60.000 131=60.000 132=60.000 133=60.000 376=0";

fn read(text: &str) -> impl Iterator<Item = (u16, String)> + '_ {
    text.split_whitespace().filter_map(|entry| {
        let (number, value) = entry.split_once('=')?;
        Some((number.parse().ok()?, value.to_owned()))
    })
}

/// Settings of a new controller.
pub fn factory_settings() -> BTreeMap<u16, String> {
    read(FACTORY).collect()
}

/// Settings of a controller configured for the robot, with screws of 60 mm.
pub fn robot_settings() -> BTreeMap<u16, String> {
    let mut settings = factory_settings();
    settings.extend(read(ROBOT));
    settings
}

/// A setting as a number, 0 if it is missing.
pub(crate) fn value(settings: &Settings, number: u16) -> f64 {
    settings.get(&number).and_then(|text| text.parse().ok()).unwrap_or(0.0)
}

/// A setting as a bit mask.
pub(crate) fn bits(settings: &Settings, number: u16) -> u32 {
    value(settings, number) as u32
}

/// Whether `$22` turns homing on (1) and requires it after a start (4).
pub(crate) fn homing_required(settings: &Settings) -> bool {
    bits(settings, 22) & 5 == 5
}

/// The values of all four axes.
pub(crate) fn of_axes(settings: &Settings, first: u16) -> [f64; 4] {
    [0, 1, 2, 3].map(|axis| value(settings, first + axis))
}

/// Executes `$number=value`; on failure returns the error number.
pub(crate) fn write(settings: &mut Settings, text: &str) -> Result<(), u16> {
    let (number, new) = text.split_once('=').ok_or(3_u16)?;
    let number: u16 = number.parse().map_err(|_| 3_u16)?;
    let new: f64 = new.parse().map_err(|_| 2_u16)?;
    let homing = bits(settings, 22) & 1 == 1;
    let old = settings.get_mut(&number).ok_or(53_u16)?;
    if new < 0.0 && !old.starts_with('-') {
        return Err(4);
    }
    if number == 20 && new != 0.0 && !homing {
        return Err(10);
    }
    let decimals = old.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    *old = format!("{new:.decimals$}");
    Ok(())
}
