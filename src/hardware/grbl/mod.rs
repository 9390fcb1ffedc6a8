//! The four lead screws, driven by a GRBL controller (grblHAL, axes X, Y, Z and A) over a serial
//! line.
//!
//! Moves are plain `G1` lines: a feed hold stops those and keeps the position, but does not stop a
//! jog.

mod check;
pub mod codes;
mod controller;
mod fault;
mod gcode;
mod handshake;
mod motion_monitor;
pub mod parser;
mod pending;
mod poll;
mod port;
mod replies;
mod resumption;
mod settings;
mod state;

pub use check::WrongSetting;
pub use controller::Controller;
pub use fault::{MotionFault, MoveRefusal};
pub use handshake::ControllerInfo;
pub use settings::MotionSettings;
pub use state::{AXIS_NAMES, ControllerState, Mode, Pins};
