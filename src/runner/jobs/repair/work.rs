//! A robot at work under a monitor: as it is, and after a change that nobody announced.

use crate::base::{Point3, Seed};
use crate::learn::gp::Gp;
use crate::policies::GpError;
use crate::runner::graph::stage::{Handle, Stage, StageInputs, StageKind};
use crate::runner::jobs::parts::identified::Identified;
use crate::runner::jobs::trials::reach_track::{Condition, PartHandles, Players};
use crate::tasks::{Monitor, MonitorOptions, WatchedRobot, Work};
use serde::{Deserialize, Serialize};

/// Handles of what the working policy needs, of the points that it works on, and of the error
/// model.
type WorkInputs = (PartHandles, Handle<Vec<Point3>>, Handle<Gp>);

/// A monitor, calibrated and tried on further work of the unchanged robot.
pub(crate) const MONITOR: Stage<WorkParams, WorkInputs, TriedMonitor> = Stage {
    kind: StageKind { name: "monitor", module: module_path!(), cost_ms: 60_000 },
    job: |params, inputs| {
        let (mut work, options, step_s) =
            (params.begin(inputs)?, &params.options, params.condition.step_s);
        let trial_s = options.trial_steps as f64 * step_s;
        let calibration_trials = (options.calibration_s / trial_s).ceil() as u64;
        let calibration: Vec<Vec<Point3>> = (0..calibration_trials)
            .map(|index| work.innovations_m(index).into_iter().flatten().collect())
            .collect();
        let monitor =
            Monitor::calibrate(&calibration, options, step_s, Seed(params.condition.seed));
        let monitor = monitor.map_err(|error| error.to_string())?;
        let watched_trials = (options.watched_s / trial_s).ceil() as u64;
        let mut state = monitor.watch();
        let mut false_alarms = 0;
        for index in calibration_trials..calibration_trials + watched_trials {
            let innovations = work.innovations_m(index);
            false_alarms += innovations
                .iter()
                .flatten()
                .filter(|innovation_m| state.alarms(innovation_m))
                .count() as u64;
        }
        Ok(TriedMonitor { monitor, watched_s: watched_trials as f64 * trial_s, false_alarms })
    },
};

/// The time of work of the changed robot until the alarm, seconds; nothing where the monitor stays
/// silent.
pub(crate) const ALARM: Stage<WorkParams, (WorkInputs, Handle<TriedMonitor>), Option<f64>> =
    Stage {
        kind: StageKind { name: "alarm", module: module_path!(), cost_ms: 500 },
        job: |params, (inputs, tried)| {
            let (mut work, step_s) = (params.begin(inputs)?, params.condition.step_s);
            let mut state = tried.monitor.watch();
            let trial_s = params.options.trial_steps as f64 * step_s;
            for index in 0..(params.options.patience_s / trial_s).ceil() as u64 {
                let alarms = |innovation_m: &Option<Point3>| {
                    innovation_m.as_ref().is_some_and(|innovation_m| state.alarms(innovation_m))
                };
                if let Some(place) = work.innovations_m(index).iter().position(alarms) {
                    return Ok(Some(index as f64 * trial_s + (place + 1) as f64 * step_s));
                }
            }
            Ok(None)
        },
    };

/// What work is.
#[derive(serde::Serialize)]
pub(crate) struct WorkParams {
    /// The policy and its robot.
    pub(crate) condition: Condition,
    /// The model that plays the same commands.
    pub(crate) model: Identified,
    pub(crate) options: MonitorOptions,
}

/// A calibrated monitor and its false alarms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct TriedMonitor {
    pub(crate) monitor: Monitor,
    /// Time of work of the unchanged robot in which alarms were counted, seconds.
    pub(crate) watched_s: f64,
    pub(crate) false_alarms: u64,
}

impl WorkParams {
    fn begin<'a>(
        &self,
        (parts, pool_m, gp): <WorkInputs as StageInputs>::Results<'a>,
    ) -> Result<Work<'a>, String> {
        let model = self.model.build(&[], self.condition.step_s)?;
        let error =
            GpError::new(gp.clone(), self.model.tendons()).map_err(|error| error.to_string())?;
        let Players { policy, plant } = self.condition.policy_and_plant(parts)?;
        Ok(Work {
            robot: WatchedRobot { plant, quiet: Some(model) },
            policy,
            error: Box::new(error),
            pool_m,
            steps: self.options.trial_steps,
            seed: Seed(self.condition.seed),
        })
    }
}
