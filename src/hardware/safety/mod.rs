//! Between policy and motors: what may leave, and what happens when something goes wrong.

mod guard;
mod latch;
mod limits;

pub use guard::{Guard, GuardState, SafetyAction, SafetyInputs, StopReason};
pub use latch::Latch;
pub use limits::{CommandRefusal, MAX_TICKS, SafetyLimits};
