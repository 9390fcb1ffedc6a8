//! Commands on standard input that inject faults into the simulators.

use spinebench::hardware::grbl::AXIS_NAMES;
use spinebench::simulators::{ControllerFault, Intervention, Simulator, TrackedBody, TrackerFault};

/// How much earlier a torn report reads its last axis, s: as measured with grblHAL's simulator.
const TORN_S: f64 = 0.0064;

const HELP: &str = "hang KG          hang a weight on the tip, kilograms; 0 removes it
unplug           unplug the serial cable
power            interrupt the controller's power briefly
mute DEVICE      silence the controller (`motors`) or the tracker (`tracker`)
freeze DEVICE    `motors`: stop motion and repeat the last report; `tracker`: repeat one pose; `tip`: of the tip alone,
                 with noise of 0.02 mm
second server    also stream other poses from the tracker's address and port
lose SHARE       lose this share of the tracker's frames
jitter S         delay the tracker's frames by random times up to S seconds
lose query       lose the controller's next `?`
babble           send bytes from the controller that do not form lines
slow S           delay the controller's answers, seconds
hide BODY        hide `tip` or `base` from the cameras
jump M           displace the measured tip, metres
swap             interchange the two bodies
dead AXIS        block an axis (X, Y, Z, A)
slip AXIS        let an axis count its steps without turning
miss AXIS MM     let an axis lose steps: its screw is MM millimetres from the counted position
torn             read the last axis of one report during a move 6 ms before the others
press AXIS       close a limit switch
alarm N          stop the controller with alarm N
tell homed       include the homing state in every report of the controller
set N VALUE      change setting $N of the controller
repair           clear all faults, except an unplugged cable and changed settings
quit             end the rehearsal";

/// Parses a command.
///
/// # Errors
/// A message: the list of all commands, or what was expected.
pub(super) fn parse(text: &str) -> Result<Intervention, String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    match words[..] {
        ["hang", load] => {
            let load_kg = number(load)?;
            if !(0.0..=10.0).contains(&load_kg) {
                return Err(format!("found {load_kg} kg, expected 0 to 10"));
            }
            Ok(Box::new(move |simulator: &mut Simulator| simulator.hang_weight(load_kg)))
        }
        ["repair"] => Ok(Box::new(|simulator: &mut Simulator| {
            simulator.controller.clear_faults();
            simulator.tracker.clear_faults();
        })),
        ["freeze", "tracker"] => tracker(TrackerFault::Frozen),
        ["freeze", "tip"] => tracker(TrackerFault::FrozenTip(2e-5)),
        ["second", "server"] => {
            tracker(TrackerFault::SameAddress { frames: 77_777, clock_s: 500.0, alone: false })
        }
        ["lose", "query"] => motors(ControllerFault::LostQuery),
        ["lose", share] => tracker(TrackerFault::Loss(number(share)?.clamp(0.0, 1.0))),
        ["jitter", delay] => tracker(TrackerFault::Jitter(number(delay)?.max(0.0))),
        ["mute", "tracker"] => tracker(TrackerFault::Silent),
        ["hide", "tip"] => tracker(TrackerFault::Occluded(TrackedBody::Tip)),
        ["hide", "base"] => tracker(TrackerFault::Occluded(TrackedBody::Base)),
        ["jump", way] => tracker(TrackerFault::Jump(number(way)?)),
        ["swap"] => tracker(TrackerFault::SwappedBodies),
        _ => of_motors(&words),
    }
}

fn of_motors(words: &[&str]) -> Result<Intervention, String> {
    match *words {
        ["unplug"] => motors(ControllerFault::Unplugged),
        ["babble"] => motors(ControllerFault::Babble),
        ["power"] => motors(ControllerFault::Reboot),
        ["mute", "motors"] => motors(ControllerFault::Silent),
        ["freeze", "motors"] => motors(ControllerFault::Frozen),
        ["slow", late] => motors(ControllerFault::SlowReplies(number(late)?.max(0.0))),
        ["dead", name] => motors(ControllerFault::DeadAxis(axis(name)?)),
        ["slip", name] => motors(ControllerFault::SlippingAxis(axis(name)?)),
        ["miss", name, way_mm] => motors(ControllerFault::LostSteps(axis(name)?, number(way_mm)?)),
        ["torn"] => motors(ControllerFault::TornReport(TORN_S)),
        ["press", name] => motors(ControllerFault::HardLimit(axis(name)?)),
        ["alarm", code] => motors(ControllerFault::SpuriousAlarm(whole(code)?)),
        ["tell", "homed"] => motors(ControllerFault::TellsHomed),
        ["set", setting, value] => {
            motors(ControllerFault::WrongSettings(whole(setting)?, value.to_owned()))
        }
        _ => Err(HELP.to_owned()),
    }
}

fn motors(fault: ControllerFault) -> Result<Intervention, String> {
    Ok(Box::new(move |simulator: &mut Simulator| simulator.controller.inject(fault)))
}

fn tracker(fault: TrackerFault) -> Result<Intervention, String> {
    Ok(Box::new(move |simulator: &mut Simulator| simulator.tracker.inject(fault)))
}

fn number(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("found `{text}`, expected a number"))
}

fn whole(text: &str) -> Result<u16, String> {
    text.parse().map_err(|_| format!("found `{text}`, expected a whole number"))
}

fn axis(name: &str) -> Result<usize, String> {
    let index = AXIS_NAMES.iter().position(|axis| name.eq_ignore_ascii_case(&axis.to_string()));
    index.ok_or_else(|| format!("found `{name}`, expected X, Y, Z or A"))
}
