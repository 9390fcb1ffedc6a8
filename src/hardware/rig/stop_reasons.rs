//! Reasons of holds and stops, with remedies.

use crate::hardware::grbl::MotionFault;
use crate::hardware::safety::StopReason;

pub(super) const INTERRUPTED: &str = "interrupted";
pub(super) const ENDED: &str = "ended";
/// How to continue after most stops.
pub(super) const ARM: &str = "inspect the robot, then run `spinebench arm --plant PLANT.yaml`";

pub(super) fn interrupted() -> StopReason {
    StopReason {
        kind: INTERRUPTED,
        what: "the program was interrupted".to_owned(),
        remedy: "the robot is held in place; start the program again to continue".to_owned(),
    }
}

pub(super) fn program_ended(why: &str) -> StopReason {
    StopReason {
        kind: ENDED,
        what: why.to_owned(),
        remedy: "start the program again to continue".to_owned(),
    }
}

pub(super) fn controller_fault(fault: &MotionFault) -> StopReason {
    StopReason { kind: "controller", what: fault.to_string(), remedy: ARM.to_owned() }
}

pub(super) fn late_answer(waiting_s: f64) -> StopReason {
    let what = format!("no answer of the controller for {:.0} ms", waiting_s * 1e3);
    StopReason { kind: "controller", what, remedy: ARM.to_owned() }
}

pub(super) fn implausible(what: String) -> StopReason {
    StopReason {
        kind: "tip",
        what,
        remedy: "check bodies, frames and tendons with `spinebench doctor`, then run `spinebench \
                 arm --plant PLANT.yaml`"
            .to_owned(),
    }
}
