//! Trials of fixed duration: responses to targets, and laps of the path in time.

use super::identified::Identified;
use super::targets::Targets;
use super::trials::{Condition, PartHandles};
use crate::base::{Point3, Seed};
use crate::data::responses::{PaceRow, ResponseRow};
use crate::runner::stage::{Handle, Stage, StageKind};
use crate::tasks::{self, Lap, Response, WatchedRobot};

/// Responses to the targets; what labels the rows is filled in by whoever publishes them.
pub(in crate::runner) const RESPONSE: Stage<ResponseParams, (PartHandles, Handle<Targets>), Vec<ResponseRow>> = Stage {
    kind: StageKind { name: "response", module: module_path!(), cost_ms: 3000 },
    job: |params, (parts, targets)| {
        let condition = &params.condition;
        let (mut policy, mut robot) = (condition.policy(parts)?, params.robot()?);
        let limits = (params.duration_s, condition.options.limits.max_step_m);
        let mut rows = Vec::with_capacity(targets.len());
        // The seed of a trial depends on its target's number, never on the policy.
        for (draw, (_, target_m)) in targets.iter().enumerate() {
            let seed = Seed(condition.seed).index(draw as u64);
            let found = tasks::response(&mut robot, policy.as_mut(), target_m, condition.feedback, limits, seed);
            rows.push(response_row(draw, &found.map_err(|error| error.to_string())?));
        }
        Ok(rows)
    },
};

/// A lap at each speed; what labels the rows is filled in by whoever publishes them.
pub(in crate::runner) const PACE: Stage<PaceParams, (PartHandles, Handle<Vec<Point3>>), Vec<PaceRow>> = Stage {
    kind: StageKind { name: "pace", module: module_path!(), cost_ms: 2000 },
    job: |params, (parts, path)| {
        let condition = &params.trial.condition;
        let (mut policy, mut robot) = (condition.policy(parts)?, params.trial.robot()?);
        let lap = |&speed: &f64| {
            let (times_s, seed) = ((params.trial.duration_s, params.lap_s / speed), Seed(condition.seed));
            let found = tasks::lap(&mut robot, policy.as_mut(), path, condition.feedback, times_s, seed);
            let found = found.map_err(|error| error.to_string())?;
            Ok(pace_row(speed, params.lap_s / speed, &found))
        };
        params.speeds.iter().map(lap).collect()
    },
};

/// Parameters of [`RESPONSE`].
#[derive(serde::Serialize)]
pub(in crate::runner) struct ResponseParams {
    pub(in crate::runner) condition: Condition,
    /// The robot measured without noise; nothing for one on a bench.
    pub(in crate::runner) quiet: Option<Identified>,
    /// Duration of a trial, or of the way to the beginning of the path, seconds.
    pub(in crate::runner) duration_s: f64,
}

/// Parameters of [`PACE`].
#[derive(serde::Serialize)]
pub(in crate::runner) struct PaceParams {
    pub(in crate::runner) trial: ResponseParams,
    /// Duration of the lap at speed 1, seconds.
    pub(in crate::runner) lap_s: f64,
    pub(in crate::runner) speeds: Vec<f64>,
}

impl ResponseParams {
    fn robot(&self) -> Result<WatchedRobot, String> {
        let build = |quiet: &Identified| quiet.build(&self.condition.effects, self.condition.step_s);
        Ok(WatchedRobot { plant: self.condition.plant()?, quiet: self.quiet.as_ref().map(build).transpose()? })
    }
}

fn response_row(draw: usize, found: &Response) -> ResponseRow {
    let [within_5mm_s, within_3mm_s, within_2mm_s] = found.within_s;
    let [error_1s_m, error_2s_m, error_5s_m] = found.error_after_m;
    ResponseRow {
        distance_m: found.distance_m,
        limit_s: found.limit_s,
        within_5mm_s,
        within_3mm_s,
        within_2mm_s,
        error_1s_m,
        error_2s_m,
        error_5s_m,
        error_end_m: found.error_end_m,
        tracked_end_m: found.tracked_end_m,
        overshoot_m: found.overshoot_m,
        tendon_travel_m: found.tendon_travel_m,
        ..ResponseRow::unmeasured(draw as u64, found.status.clone())
    }
}

fn pace_row(speed: f64, lap_s: f64, found: &Lap) -> PaceRow {
    PaceRow {
        rms_m: found.rms_m,
        largest_m: found.largest_m,
        tracked_rms_m: found.tracked_rms_m,
        tendon_travel_m: found.tendon_travel_m,
        ..PaceRow::unmeasured(speed, lap_s, found.status.clone())
    }
}
