//! A bench without a robot: imitations of the motors and the tracker, and a clock of its own.

mod axes;
mod clock;
mod controller;
mod pipe;
mod tracker;
mod world;

pub use clock::RehearsalClock;
pub use controller::{FakeController, FakeFault as ControllerFault, FakeOptions as ControllerOptions};
pub use controller::{factory_settings, robot_settings};
pub use pipe::{PipeWire, pipe};
pub use tracker::{FakeBody, FakeFault as TrackerFault, FakeTracker, FakeTrackerOptions as TrackerOptions};
pub use world::{Body, Plan, Running, Sight, World};
