//! Simulators of the motor controller and of the tracker, and a clock for rehearsals.
//!
//! The real drivers talk to them over a serial line and UDP: `spinebench rehearse` serves them to
//! other programs, a plant with `rehearsal:` runs them in the same process.

mod axes;
mod clock;
mod controller;
mod pipe;
mod simulator;
mod tracker;

pub use clock::RehearsalClock;
pub use controller::{
    ControllerFault, ControllerOptions, SimulatedController, factory_settings, robot_settings,
};
pub use pipe::{PipeEnd, pipe};
pub use simulator::{Intervention, RunningSimulator, SimulatedRobot, Simulator, TrackerView};
pub use tracker::{SimulatedTracker, TrackedBody, TrackerFault, TrackerOptions};
