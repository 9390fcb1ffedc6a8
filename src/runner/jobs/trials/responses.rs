//! Trials of fixed duration: responses to targets, and laps of the path in time.

use super::reach_track::{Condition, PartHandles, Players};
use crate::base::{Plant, Point3, Seed, report_share};
use crate::rows::responses::{PaceLap, ResponseTrial};
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::data::targets::Targets;
use crate::runner::jobs::parts::identified::Identified;
use crate::tasks::{self, Lap, LapTimes, Response, ResponseLimits, WatchedRobot};

/// Responses to the targets.
pub(crate) const RESPONSE: Stage<
    ResponseParams,
    (PartHandles, Handle<Targets>),
    Vec<ResponseTrial>,
> = Stage {
    kind: StageKind { name: "response", module: module_path!(), cost_ms: 3000 },
    job: |params, (parts, targets)| {
        let condition = &params.condition;
        let Players { mut policy, plant } = condition.policy_and_plant(parts)?;
        let mut robot = params.watched(plant)?;
        let max_step_m = condition.options.limits.max_step_m;
        let limits = ResponseLimits { duration_s: params.duration_s, max_step_m };
        let mut trials = Vec::with_capacity(targets.len());
        // The seed of a trial depends on its target's number, never on the policy.
        for (draw, (_, target_m)) in targets.iter().enumerate() {
            report_share(draw, targets.len());
            let seed = Seed(condition.seed).index(draw as u64);
            let response = tasks::response(
                &mut robot,
                policy.as_mut(),
                target_m,
                condition.feedback,
                limits,
                seed,
            );
            trials.push(response_trial(draw, response.map_err(|error| error.to_string())?));
        }
        Ok(trials)
    },
};

/// A lap at each speed.
pub(crate) const PACE: Stage<PaceParams, (PartHandles, Handle<Vec<Point3>>), Vec<PaceLap>> =
    Stage {
        kind: StageKind { name: "pace", module: module_path!(), cost_ms: 2000 },
        job: |params, (parts, path)| {
            let condition = &params.trial.condition;
            let Players { mut policy, plant } = condition.policy_and_plant(parts)?;
            let mut robot = params.trial.watched(plant)?;
            let lap = |&speed: &f64| {
                let times =
                    LapTimes { lead_in_s: params.trial.duration_s, lap_s: params.lap_s / speed };
                let seed = Seed(condition.seed);
                let lap =
                    tasks::lap(&mut robot, policy.as_mut(), path, condition.feedback, times, seed);
                Ok(pace_lap(speed, times.lap_s, lap.map_err(|error| error.to_string())?))
            };
            params.speeds.iter().map(lap).collect()
        },
    };

/// Parameters of [`RESPONSE`].
#[derive(serde::Serialize)]
pub(crate) struct ResponseParams {
    pub(crate) condition: Condition,
    /// The robot measured without noise; nothing for one on a bench.
    pub(crate) quiet: Option<Identified>,
    /// Duration of a trial, or of the way to the beginning of the path, seconds.
    pub(crate) duration_s: f64,
}

/// Parameters of [`PACE`].
#[derive(serde::Serialize)]
pub(crate) struct PaceParams {
    pub(crate) trial: ResponseParams,
    /// Duration of the lap at speed 1, seconds.
    pub(crate) lap_s: f64,
    pub(crate) speeds: Vec<f64>,
}

impl ResponseParams {
    fn watched(&self, plant: Box<dyn Plant>) -> Result<WatchedRobot, String> {
        let quiet = self.quiet.as_ref().map(|quiet| self.condition.robot(quiet)).transpose()?;
        Ok(WatchedRobot { plant, quiet })
    }
}

fn response_trial(target: usize, response: Response) -> ResponseTrial {
    let [within_5mm_s, within_3mm_s, within_2mm_s] = response.within_s;
    let [error_1s_m, error_2s_m, error_5s_m] = response.error_after_m;
    ResponseTrial {
        target: target as u64,
        distance_m: response.distance_m,
        limit_s: response.limit_s,
        within_5mm_s,
        within_3mm_s,
        within_2mm_s,
        error_1s_m,
        error_2s_m,
        error_5s_m,
        error_end_m: response.error_end_m,
        tracked_end_m: response.tracked_end_m,
        overshoot_m: response.overshoot_m,
        tendon_travel_m: response.tendon_travel_m,
        status: response.status,
    }
}

fn pace_lap(speed: f64, lap_s: f64, lap: Lap) -> PaceLap {
    let Lap { rms_m, largest_m, tracked_rms_m, tendon_travel_m, status } = lap;
    PaceLap { speed, lap_s, rms_m, largest_m, tracked_rms_m, tendon_travel_m, status }
}
