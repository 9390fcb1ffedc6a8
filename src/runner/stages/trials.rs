//! Trials: goal reaching and path tracking of one policy under one condition.

use super::data::Targets;
use super::identified::Identified;
use super::shared::SharedPart;
use super::{Added, Stages, status};
use crate::base::{Point3, Policy, Seed};
use crate::data::rows::{TrackRow, TrialRow};
use crate::effects::EffectSpec;
use crate::learn::gp::Gp;
use crate::learn::rnn::Trained;
use crate::policies::{self, ElmanInverse, GpError, InverseModel, Part, PolicyEntry, PolicyOptions, PolicyParts};
use crate::runner::graph::{Failure, Handle, Inputs, StageKind};
use crate::runner::source_digest::TRIAL;
use crate::specs::{Training, TrialCell, TrialMode};
use crate::tasks::{self, LoopMode, ReachOptions, ReachOutcome, TrackStep};
use std::sync::Arc;

const REACH: StageKind = StageKind { name: "reach", sources: TRIAL, cost_ms: 1000 };
const TRACK: StageKind = StageKind { name: "track", sources: TRIAL, cost_ms: 1000 };
/// All of this file.
pub(super) const KINDS: [StageKind; 2] = [REACH, TRACK];

/// Where a policy's parts come from.
#[derive(Clone, Copy, Default)]
struct PartStages {
    simulated: Option<Handle<Trained>>,
    generated: Option<Handle<Trained>>,
    real: Option<Handle<Trained>>,
    error: Option<Handle<Gp>>,
}

impl PartStages {
    fn numbers(&self) -> Vec<usize> {
        let networks = [self.simulated, self.generated, self.real].into_iter().flatten().map(Handle::number);
        networks.chain(self.error.map(Handle::number)).collect()
    }

    fn policy(&self, given: &Inputs, entry: &PolicyEntry, options: &PolicyOptions) -> Result<Box<dyn Policy>, String> {
        let network = |stage: Option<Handle<Trained>>| -> Result<Option<Box<dyn InverseModel>>, String> {
            let Some(stage) = stage else { return Ok(None) };
            let network = Arc::new(given.get(stage)?.network.clone());
            Ok(Some(Box::new(ElmanInverse::new(network).map_err(status)?)))
        };
        let mut parts = PolicyParts {
            simulated: network(self.simulated)?,
            generated: network(self.generated)?,
            real: network(self.real)?,
            error: None,
        };
        if let Some(stage) = self.error {
            let gp = given.get(stage)?.clone();
            let tendons = gp.inputs().saturating_sub(3);
            parts.error = Some(Arc::new(GpError::new(gp, tendons).map_err(status)?));
        }
        policies::build(entry, parts, options).map_err(status)
    }
}

/// All that a trial depends on besides its inputs.
#[derive(Clone, serde::Serialize)]
struct Condition {
    policy: String,
    options: SharedPart<PolicyOptions>,
    plant: Identified,
    /// What the mode puts on top of the robot's own.
    effects: Vec<EffectSpec>,
    feedback: LoopMode,
    step_s: f64,
    seed: u64,
}

impl Stages<'_> {
    /// Goal reaching in one cell; seed and training of the rows are filled in by whoever publishes them.
    pub(crate) fn reach(&mut self, cell: &TrialCell, training: &Training) -> Added<Vec<TrialRow>> {
        let (entry, condition) = self.condition(cell, "reach")?;
        let (parts, targets, options) = (self.parts(entry, cell, training)?, self.targets()?, self.spec.reach);
        let inputs: Vec<usize> = parts.numbers().into_iter().chain([targets.number()]).collect();
        let label = self.label(&format!("{} {}", cell.policy, cell.mode));
        let (params, cell) = ((condition.clone(), options), cell.clone());
        self.graph.stage(REACH, label, &params, &inputs, move |given| {
            let policy = parts.policy(given, entry, &condition.options)?;
            reach_all(&condition, policy, given.get(targets)?, &options, &cell)
        })
    }

    /// Path tracking of one policy; seed and training of the rows are filled in by whoever publishes them.
    pub(crate) fn track(&mut self, cell: &TrialCell, training: &Training) -> Added<Vec<TrackRow>> {
        let (entry, condition) = self.condition(cell, "track")?;
        let (parts, path, options) = (self.parts(entry, cell, training)?, self.path()?, self.spec.track);
        let inputs: Vec<usize> = parts.numbers().into_iter().chain([path.number()]).collect();
        let label = self.label(&format!("{} tracks", cell.policy));
        self.graph.stage(TRACK, label, &(condition.clone(), options), &inputs, move |given| {
            let mut policy = parts.policy(given, entry, &condition.options)?;
            let mut plant = condition.plant.build(&condition.effects, condition.step_s)?;
            let path: &Vec<Point3> = given.get(path)?;
            let steps = tasks::track(plant.as_mut(), policy.as_mut(), path, &options, Seed(condition.seed));
            Ok(steps.map_err(status)?.iter().map(|step| track_row(&condition.policy, step)).collect())
        })
    }

    fn condition(&self, cell: &TrialCell, task: &str) -> Result<(&'static PolicyEntry, Condition), Failure> {
        let unknown = |what: &str| Failure { stage: task.to_owned(), status: format!("unknown {what}") };
        let entry = policies::find(&cell.policy).ok_or_else(|| unknown(&cell.policy))?;
        let mode: &TrialMode = self.spec.modes.get(&cell.mode).ok_or_else(|| unknown(&cell.mode))?;
        let condition = Condition {
            policy: cell.policy.clone(),
            options: self.parts.policies.clone(),
            plant: self.parts.plant.clone(),
            effects: mode.effects.clone(),
            feedback: mode.feedback,
            step_s: self.step_s(),
            seed: self.seed.child(task).0,
        };
        Ok((entry, condition))
    }

    fn parts(&mut self, entry: &PolicyEntry, cell: &TrialCell, training: &Training) -> Result<PartStages, Failure> {
        let mut parts = PartStages::default();
        for part in entry.needs {
            match part {
                Part::SimulatedInverse => parts.simulated = Some(self.inverse(training)?),
                Part::GeneratedInverse => parts.generated = Some(self.generated(training, cell.gp_points)?),
                Part::RealInverse => parts.real = Some(self.pi_real(training, cell.real_points)?),
                Part::Error => parts.error = Some(self.gp(training, cell.gp_points)?),
            }
        }
        Ok(parts)
    }
}

/// One trial a target. The seed of a trial depends on its target's number, never on the policy.
fn reach_all(
    condition: &Condition,
    mut policy: Box<dyn Policy>,
    targets: &Targets,
    options: &ReachOptions,
    cell: &TrialCell,
) -> Result<Vec<TrialRow>, String> {
    let mut plant = condition.plant.build(&condition.effects, condition.step_s)?;
    let mut rows = Vec::with_capacity(targets.len());
    for (draw, (_, target_m)) in targets.iter().enumerate() {
        let seed = Seed(condition.seed).index(draw as u64);
        let outcome = tasks::reach(plant.as_mut(), policy.as_mut(), target_m, condition.feedback, options, seed);
        rows.push(trial_row(cell, draw, target_m, &outcome.map_err(status)?));
    }
    Ok(rows)
}

fn trial_row(cell: &TrialCell, draw: usize, target_m: &Point3, outcome: &ReachOutcome) -> TrialRow {
    TrialRow {
        seed: 0,
        training: String::new(),
        policy: cell.policy.clone(),
        mode: cell.mode.clone(),
        gp_points: cell.gp_points as u64,
        real_points: cell.real_points as u64,
        target: draw as u64,
        target_x_m: target_m[0],
        target_y_m: target_m[1],
        target_z_m: target_m[2],
        tip_x_m: outcome.tip_m[0],
        tip_y_m: outcome.tip_m[1],
        tip_z_m: outcome.tip_m[2],
        error_m: outcome.error_m,
        steps: outcome.steps as u64,
        settled: outcome.settled,
        switches: outcome.switches as u64,
        status: outcome.status.clone(),
    }
}

fn track_row(policy: &str, step: &TrackStep) -> TrackRow {
    TrackRow {
        seed: 0,
        training: String::new(),
        policy: policy.to_owned(),
        step: step.step as u64,
        time_s: step.time_s,
        path_point: step.path_point as u64,
        target_x_m: step.target_m[0],
        target_y_m: step.target_m[1],
        target_z_m: step.target_m[2],
        tip_x_m: step.tip_m[0],
        tip_y_m: step.tip_m[1],
        tip_z_m: step.tip_m[2],
        error_m: step.error_m,
        branch: step.branch.to_owned(),
        status: step.status.clone(),
    }
}
