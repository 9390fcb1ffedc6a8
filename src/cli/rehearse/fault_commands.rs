//! What somebody may wish to happen to imitated motors and an imitated tracker.

use spinebench::hardware::grbl::AXIS_NAMES;
use spinebench::simulators::{ControllerFault, Intervention, Simulator, TrackedBody, TrackerFault};

const HELP: &str = "\
hang KG          a weight on the tip, kilograms; 0 takes it off
unplug           the serial cable is pulled
power            the controller loses its power for a moment
mute MOTORS      the controller (`motors`) or the tracker (`tracker`) says nothing
freeze DEVICE    `motors` stand still and say what they said last; `tracker` sends one pose for ever
slow S           the controller answers so many seconds later
hide BODY        the cameras do not see `tip` or `base`
jump M           the tip is seen so many metres beside where it is
swap             the two bodies are taken for each other
dead AXIS        an axis (X, Y, Z, A) does not turn
press AXIS       a limit switch closes
alarm N          the controller stops with alarm N
tell homed       every report of the controller says whether it is homed
set N VALUE      setting $N of the controller has another value
repair           all of this ends, except for a pulled cable and settings
quit             the rehearsal ends";

/// What `text` asks for.
///
/// # Errors
/// In words: the list of all that there is, or what was expected.
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
        ["power"] => motors(ControllerFault::Reboot),
        ["mute", "motors"] => motors(ControllerFault::Silent),
        ["freeze", "motors"] => motors(ControllerFault::Frozen),
        ["slow", late] => motors(ControllerFault::SlowReplies(number(late)?.max(0.0))),
        ["dead", name] => motors(ControllerFault::DeadAxis(axis(name)?)),
        ["press", name] => motors(ControllerFault::HardLimit(axis(name)?)),
        ["alarm", code] => motors(ControllerFault::SpuriousAlarm(whole(code)?)),
        ["tell", "homed"] => motors(ControllerFault::TellsHomed),
        ["set", setting, value] => motors(ControllerFault::WrongSettings(whole(setting)?, value.to_owned())),
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
    let found = AXIS_NAMES.iter().position(|axis| name.eq_ignore_ascii_case(&axis.to_string()));
    found.ok_or_else(|| format!("found `{name}`, expected X, Y, Z or A"))
}
