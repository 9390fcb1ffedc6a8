//! The four lead screws, driven by a GRBL controller (grblHAL, axes X, Y, Z and A) over a serial line.
//!
//! Moves are plain `G1` lines: a feed hold stops those and keeps the position, while it does not stop a jog.

mod check;
pub mod codes;
mod controller;
mod fault;
pub mod line;
mod moves;
mod open;
mod port;
mod replies;
mod schedule;
mod settings;
mod state;
mod watch;

pub use controller::Controller;
pub use fault::{MotionFault, Refusal};
pub use open::Machine;
pub use settings::MotionSettings;
pub use state::{AXIS_NAMES, Mode, Pins, State};
