//! A robot on a bench: four lead screws, a tracker, and the guard between them and whoever decides.

pub(crate) mod diagnostics;
pub(crate) mod dry_run;
mod opening;
pub mod operator;
mod options;
pub(crate) mod payload;
mod plant;
mod rehearsal;
pub(crate) mod served_simulator;
pub(crate) mod supervised_rig;
mod timing;

pub use diagnostics::Diagnostics;
pub use dry_run::{DryRun, RefusedRow, dry_run};
pub use options::{HardwareOptions, RehearsalOptions};
pub use rehearsal::Rehearsal;
pub use served_simulator::ServedSimulator;
pub use timing::{Lateness, LoopTiming};

use crate::base::Point3;
use crate::effects::{Driven, Model};
use crate::hardware::rig::{Event, Rig};
use crate::hardware::safety::SafetyLimits;

use operator::RobotLock;
use supervised_rig::SupervisedRig;

/// A hardware robot as a [`Plant`](crate::base::Plant).
pub struct Hardware {
    supervised: SupervisedRig,
    /// What is believed about the robot.
    unloaded_model: Model,
    /// What that says the robot does: how tendons follow, where the tip may be.
    model: Driven,
    step_s: f64,
    settle_s: f64,
    safety: SafetyLimits,
    /// Longest that a held robot or a busy controller is waited for, s.
    patience_s: f64,
    /// When the trial began and when its next tick is due, on the rig's clock, s.
    trial_s: f64,
    due_s: f64,
    timing: LoopTiming,
    /// The imitations behind the drivers, in a rehearsal.
    rehearsal: Option<Rehearsal>,
    /// The right to use the robot, where there is one. Given back last.
    lock: Option<RobotLock>,
}

impl Hardware {
    /// What has happened to the robot so far.
    pub fn events(&self) -> Vec<Event> {
        self.supervised.rig().events().to_vec()
    }

    /// Time on the rig's clock, s: that of [`Hardware::events`].
    pub fn now_s(&self) -> f64 {
        self.supervised.clock.now_s()
    }

    /// How well the loop has kept time.
    pub fn timing(&self) -> &LoopTiming {
        &self.timing
    }

    /// Forgets how well the loop has kept time so far.
    pub fn reset_timing(&mut self) {
        self.timing = LoopTiming::default();
    }

    /// The imitations behind the drivers, in a rehearsal.
    pub fn rehearsal(&self) -> Option<&Rehearsal> {
        self.rehearsal.as_ref()
    }

    /// Where the model puts the tip now, metres.
    pub fn expected_m(&self) -> Point3 {
        use crate::base::TendonCommand::Pull;
        self.model.observation(&[Pull(0.0); crate::hardware::axes::AXES], 0.0).tip_m
    }

    /// Looks at the rig for a moment.
    pub fn with_rig<T>(&self, what: impl FnOnce(&Rig) -> T) -> T {
        what(&self.supervised.rig())
    }
}
