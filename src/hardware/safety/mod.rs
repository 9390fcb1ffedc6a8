//! Safety between policy and motors: the limits of commands, the state machine that holds and stops
//! the robot ([`Guard`]), and the latch that stores a stop.

mod guard;
mod latch;
mod limits;

pub use guard::{Guard, GuardState, SafetyAction, SafetyInputs, StopReason};
pub use latch::Latch;
pub use limits::{CommandRefusal, MAX_TICKS, SafetyLimits};
