//! The bench: motors, tracker, and what keeps the robot from being hurt (docs/hardware.md).

pub mod axes;
pub mod bench;
pub mod clock;
pub mod grbl;
pub mod interrupt;
pub mod rig;
pub mod safety;
pub mod tracking;
pub mod urgency;
pub mod wire;
