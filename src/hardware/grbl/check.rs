//! Checks that a controller is configured for the robot.

use std::collections::BTreeMap;

use super::fault::MotionFault;
use super::settings::MotionSettings;

/// The controller's settings by number.
pub(super) type SettingsTable = BTreeMap<u16, String>;

/// What value a setting must have.
enum Requirement {
    Exactly(f64),
    AtLeast(f64),
    Bits(u32),
    Positive,
}

struct SettingRule {
    number: u16,
    meaning: &'static str,
    need: Requirement,
    /// Firmware without this setting is accepted.
    optional: bool,
}

/// Refuses a controller whose settings do not meet the robot's requirements.
pub(super) fn check(table: &SettingsTable, settings: &MotionSettings) -> Result<(), MotionFault> {
    // Plain GRBL has its homing passes compiled in; there `$22` only turns homing on.
    let plain = PASSES.iter().all(|pass| !table.contains_key(pass));
    rules(settings, plain).iter().try_for_each(|rule| rule.check(table))?;
    if plain { Ok(()) } else { all_axes_home(table) }
}

/// The settings that name the axes of each homing pass.
const PASSES: [u16; 4] = [44, 45, 46, 47];

fn rules(settings: &MotionSettings, plain: bool) -> Vec<SettingRule> {
    let rule = |number, meaning, need| SettingRule { number, meaning, need, optional: false };
    let optional = |number, meaning, need| SettingRule { number, meaning, need, optional: true };
    let homing = if plain { 1 } else { 13 };
    let mut rules = vec![
        // Optional: the reports themselves show whether they carry machine positions.
        optional(10, "status report fields, 1: machine position", Requirement::Bits(1)),
        rule(13, "reports in inches", Requirement::Exactly(0.0)),
        rule(20, "soft limits", Requirement::Exactly(1.0)),
        rule(21, "hard limits", Requirement::Bits(1)),
        rule(22, "homing, 1: on, 4: required after start-up, 8: switches at 0", Requirement::Bits(homing)),
        rule(23, "axes that home in negative direction", Requirement::Exactly(f64::from(settings.homing_directions))),
        optional(376, "rotary axes", Requirement::Exactly(0.0)),
    ];
    if settings.hold_when_idle {
        rules.push(rule(1, "delay before idle motors are switched off, 255: never", Requirement::Exactly(255.0)));
    }
    for axis in 0..4 {
        rules.push(rule(110 + axis, "maximum speed of an axis, mm/min", Requirement::Positive));
        rules.push(rule(120 + axis, "maximum acceleration of an axis, mm/s²", Requirement::Positive));
        rules.push(rule(130 + axis, "travel of an axis, mm", Requirement::AtLeast(settings.travel_m * 1e3)));
    }
    rules
}

impl SettingRule {
    fn check(&self, table: &SettingsTable) -> Result<(), MotionFault> {
        let value = number(table, self.number);
        let missing = self.optional && !table.contains_key(&self.number);
        if missing || value.is_some_and(|value| self.need.met(value)) {
            return Ok(());
        }
        let found = table.get(&self.number).map_or("nothing", String::as_str).to_owned();
        Err(MotionFault::WrongSetting {
            number: self.number,
            meaning: self.meaning,
            found,
            expected: self.need.description(),
        })
    }
}

impl Requirement {
    fn met(&self, value: f64) -> bool {
        match *self {
            Requirement::Exactly(wanted) => value == wanted,
            // The controller rounds its settings to micrometres.
            Requirement::AtLeast(least) => value >= least - 1e-3,
            Requirement::Bits(bits) => value >= 0.0 && (value as u32) & bits == bits,
            Requirement::Positive => value > 0.0,
        }
    }

    fn description(&self) -> String {
        match self {
            Requirement::Exactly(wanted) => wanted.to_string(),
            Requirement::AtLeast(least) => format!("at least {least}"),
            Requirement::Bits(bits) => format!("a bit mask that includes {bits}"),
            Requirement::Positive => "a number above 0".to_owned(),
        }
    }
}

/// The axes of each homing pass are listed in `$44` and the settings after it; together they must cover all four.
fn all_axes_home(table: &SettingsTable) -> Result<(), MotionFault> {
    let homed = PASSES.into_iter().filter_map(|pass| number(table, pass)).fold(0, |all, axes| all | axes as u32);
    if homed & 15 == 15 {
        return Ok(());
    }
    let found = PASSES
        .into_iter()
        .filter_map(|pass| Some(format!("${pass}={}", table.get(&pass)?)))
        .collect::<Vec<_>>()
        .join(" ");
    let expected = "1, 2, 4 and 8 (X, Y, Z and A) in one of $44 to $47".to_owned();
    Err(MotionFault::WrongSetting { number: 44, meaning: "axes of a homing pass", found, expected })
}

/// The value of a setting as a number; some firmware appends a description, which is ignored.
pub(super) fn number(table: &SettingsTable, number: u16) -> Option<f64> {
    let value = table.get(&number)?.split_whitespace().next()?;
    value.parse().ok().filter(|value: &f64| value.is_finite())
}
