//! Why a rig is held or stopped, in words.

use crate::hardware::grbl::MotionFault;
use crate::hardware::safety::StopReason;
use crate::hardware::tracking::TrackingStatus;

pub(crate) const INTERRUPTED: &str = "interrupted";
pub(crate) const ENDED: &str = "ended";
/// How to go on after most stops.
pub(crate) const ARM: &str = "look at the robot, then `spinebench arm --plant PLANT.yaml`";

pub(crate) fn interrupted() -> StopReason {
    StopReason {
        kind: INTERRUPTED,
        what: "somebody asked the program to end".to_owned(),
        remedy: "the robot is held where it was; start the program again to go on".to_owned(),
    }
}

pub(crate) fn program_ended(why: &str) -> StopReason {
    StopReason { kind: ENDED, what: why.to_owned(), remedy: "start the program again to go on".to_owned() }
}

pub(crate) fn controller_fault(fault: &MotionFault) -> StopReason {
    StopReason { kind: "controller", what: fault.to_string(), remedy: ARM.to_owned() }
}

pub(crate) fn tracking_lost(age_s: f64, allowed_s: f64, status: &TrackingStatus) -> StopReason {
    let aged = || format!("the last valid pose is {:.0} ms old", age_s * 1e3);
    let found = if age_s.is_finite() { aged() } else { "no valid pose so far".to_owned() };
    let stranger = || {
        let from = status.foreign_source?;
        Some(format!("{} datagrams came from {from}, which is not the server", status.foreign))
    };
    let unseen = || status.unseen.map(str::to_owned);
    let why = status.fault.clone().or_else(unseen).or_else(stranger).or_else(|| status.socket_error.clone());
    let why = why.map(|why| format!(" ({why})")).unwrap_or_default();
    StopReason {
        kind: "tracking",
        what: format!("{found}, expected at most {:.0} ms{why}", allowed_s * 1e3),
        remedy: "make both bodies visible and check that Motive streams, then `spinebench arm --plant PLANT.yaml`"
            .to_owned(),
    }
}

pub(crate) fn implausible(what: String) -> StopReason {
    StopReason {
        kind: "tip",
        what,
        remedy: "check bodies, frames and tendons with `spinebench doctor`, then `spinebench arm --plant PLANT.yaml`"
            .to_owned(),
    }
}
