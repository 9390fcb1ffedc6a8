//! The bench: motors, tracker, and what keeps the robot from being hurt (docs/hardware.md).

pub mod axes;
pub mod clock;
pub mod grbl;
pub mod interrupt;
pub mod realtime;
pub mod rig;
pub mod safety;
pub mod serial;
pub mod tracking;
