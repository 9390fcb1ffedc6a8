//! A real robot as a plant: four lead screws, a tracker, and the guard between the policy and the
//! motors.

mod axis_response;
pub(crate) mod diagnostics;
pub(crate) mod dry_run;
mod lateness;
mod opening;
pub mod operator;
mod options;
pub(crate) mod payload;
mod plant;
mod rehearsal;
pub(crate) mod served_simulator;
pub(crate) mod supervised_rig;
mod timing;
mod trial_log;
mod verification;

pub use diagnostics::Diagnostics;
pub use dry_run::{DryRun, RefusedRow, dry_run};
pub use options::{HardwareOptions, RehearsalOptions};
pub use rehearsal::Rehearsal;
pub use served_simulator::ServedSimulator;
pub use timing::{Lateness, LoopTiming};

use crate::base::Point3;
use crate::effects::{DrivenModel, Model};
use crate::hardware::rig::{Event, Rig};
use crate::hardware::safety::SafetyLimits;

use operator::RobotLock;
use supervised_rig::SupervisedRig;
use trial_log::TrialLog;
use verification::HomeTips;

/// A real robot, or a rehearsal of one, as a [`Plant`](crate::base::Plant).
pub struct Hardware {
    supervised: SupervisedRig,
    /// Model of the robot without a weight.
    unloaded_model: Model,
    /// Model with the present weight: predicts the motion of following tendons and the tip.
    model: DrivenModel,
    step_s: f64,
    settle_s: f64,
    safety: SafetyLimits,
    /// Longest wait for a held robot or a busy controller, s.
    patience_s: f64,
    /// Start of the trial and due time of its next tick, on the rig's clock, s.
    trial_s: f64,
    due_s: f64,
    /// Events until the end of the last tick.
    seen_events: usize,
    /// How long the last observation waited for its pose, s.
    pose_wait_s: f64,
    /// The robot has rested at home since it last moved.
    rests_at_home: bool,
    /// Where the tip rested at home.
    home_tips: Option<HomeTips>,
    trial: TrialLog,
    timing: LoopTiming,
    /// The simulators behind the drivers, in a rehearsal.
    rehearsal: Option<Rehearsal>,
    /// Exclusive use of a real robot. Released last.
    lock: Option<RobotLock>,
}

impl Hardware {
    /// Events so far.
    pub fn events(&self) -> Vec<Event> {
        self.supervised.rig().events().to_vec()
    }

    /// Time on the rig's clock, s, as in [`Hardware::events`].
    pub fn now_s(&self) -> f64 {
        self.supervised.clock.now_s()
    }

    /// Timing of the control loop.
    pub fn timing(&self) -> &LoopTiming {
        &self.timing
    }

    /// Clears the timing of the control loop.
    pub fn reset_timing(&mut self) {
        self.timing = LoopTiming::default();
    }

    /// The simulators behind the drivers, in a rehearsal.
    pub fn rehearsal(&self) -> Option<&Rehearsal> {
        self.rehearsal.as_ref()
    }

    /// Tip position that the model predicts now, metres.
    pub fn expected_m(&self) -> Point3 {
        use crate::base::TendonCommand::Pull;
        self.model.observation(&[Pull(0.0); crate::hardware::axes::AXES], 0.0).tip_m
    }

    /// Calls `what` with the locked rig.
    pub fn with_rig<T>(&self, what: impl FnOnce(&Rig) -> T) -> T {
        what(&self.supervised.rig())
    }
}
