//! Between policy and motors: what may leave, and what happens when something goes wrong.

mod guard;
mod latch;
mod limits;

pub use guard::{Cause, Facts, Guard, Order, State};
pub use latch::Latch;
pub use limits::{MOST_TICKS, Refusal, SafetyLimits};
