//! Drivers of the real robot: motors, tracker, and the safety functions (docs/reference/hardware.md).
//!
//! - [`grbl`]: the motor controller.
//! - [`tracking`]: the motion capture system.
//! - [`safety`]: limits of commands; the state machine that holds and stops the robot, also when
//!   tracking is lost; the latch.
//! - [`rig`]: all three together. Every command to the robot passes through it.

pub mod axes;
pub mod clock;
pub mod grbl;
pub mod interrupt;
pub mod realtime;
pub mod rig;
pub mod safety;
pub mod serial;
pub mod tracking;
