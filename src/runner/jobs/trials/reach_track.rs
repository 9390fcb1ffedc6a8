//! Trials: goal reaching and path tracking of one policy under one condition.

use crate::base::{Plant, Point3, Policy, Seed, report_share};
use crate::effects::EffectSpec;
use crate::learn::gp::Gp;
use crate::learn::networks::Trained;
use crate::plants::RobotChange;
use crate::policies::{self, GpError, ModelAccess, PolicyOptions, PolicyParts};
use crate::rows::experiment::{ReachTrial, TrackSample};
use crate::runner::graph::stage::{Handle, Stage, StageInputs, StageKind};
use crate::runner::jobs::data::targets::Targets;
use crate::runner::jobs::parts::identified::Identified;
use crate::runner::jobs::parts::outside_part::OutsidePart;
use crate::runner::jobs::parts::shared_part::SharedPart;
use crate::tasks::{self, LoopMode, ReachOptions, ReachOutcome, TrackOptions, TrackStep};
use std::sync::Arc;

/// Handles of what a policy needs: its networks in the order of its entry, and the error model.
pub(crate) type PartHandles = (Vec<Handle<Trained>>, Option<Handle<Gp>>);

/// Goal reaching.
pub(crate) const REACH: Stage<ReachParams, (PartHandles, Handle<Targets>), Vec<ReachTrial>> =
    Stage {
        kind: StageKind { name: "reach", module: module_path!(), cost_ms: 1000 },
        job: |params, (parts, targets)| {
            let condition = &params.condition;
            let Players { mut policy, mut plant } = condition.policy_and_plant(parts)?;
            let mut trials = Vec::with_capacity(targets.len());
            // The seed of a trial depends on its target's number, never on the policy.
            for (draw, (_, target_m)) in targets.iter().enumerate() {
                report_share(draw, targets.len());
                let seed = Seed(condition.seed).index(draw as u64);
                let (feedback, options) = (condition.feedback, &params.options);
                let outcome = tasks::reach(
                    plant.as_mut(),
                    policy.as_mut(),
                    target_m,
                    feedback,
                    options,
                    seed,
                );
                trials.push(measured(draw, target_m, outcome.map_err(|error| error.to_string())?));
            }
            Ok(trials)
        },
    };

/// Path tracking.
pub(crate) const TRACK: Stage<TrackParams, (PartHandles, Handle<Vec<Point3>>), Vec<TrackSample>> =
    Stage {
        kind: StageKind { name: "track", module: module_path!(), cost_ms: 1000 },
        job: |params, (parts, path)| {
            let condition = &params.condition;
            let Players { mut policy, mut plant } = condition.policy_and_plant(parts)?;
            let steps = tasks::track(
                plant.as_mut(),
                policy.as_mut(),
                path,
                &params.options,
                Seed(condition.seed),
            );
            Ok(steps.map_err(|error| error.to_string())?.into_iter().map(track_sample).collect())
        },
    };

/// Parameters of [`REACH`].
#[derive(serde::Serialize)]
pub(crate) struct ReachParams {
    pub(crate) condition: Condition,
    pub(crate) options: ReachOptions,
}

/// Parameters of [`TRACK`].
#[derive(serde::Serialize)]
pub(crate) struct TrackParams {
    pub(crate) condition: Condition,
    pub(crate) options: TrackOptions,
}

/// All that a trial depends on besides its task and its inputs.
#[derive(serde::Serialize)]
pub(crate) struct Condition {
    /// Name of the policy.
    pub(crate) policy: String,
    /// The policy itself, where it is one from outside.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) outside: Option<OutsidePart>,
    pub(crate) options: SharedPart<PolicyOptions>,
    pub(crate) plant: Identified,
    /// The nominal model, for a policy that is told of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) model: Option<Identified>,
    /// What the mode adds to the robot's own effects.
    pub(crate) effects: Vec<EffectSpec>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) change: Option<RobotChange>,
    pub(crate) feedback: LoopMode,
    pub(crate) step_s: f64,
    pub(crate) seed: u64,
}

/// A policy and the robot of its trials.
pub(crate) struct Players {
    pub(crate) policy: Box<dyn Policy>,
    pub(crate) plant: Box<dyn Plant>,
}

impl Condition {
    /// A robot with what the mode adds to it.
    pub(crate) fn robot(&self, plant: &Identified) -> Result<Box<dyn Plant>, String> {
        plant.build_changing(&self.effects, self.change.as_ref(), self.step_s)
    }

    /// The policy, which has taken its samples of the robot without what the mode adds, and the robot
    /// of the trials.
    pub(crate) fn policy_and_plant(
        &self,
        parts: <PartHandles as StageInputs>::Results<'_>,
    ) -> Result<Players, String> {
        let mut policy = self.policy(parts)?;
        if self.outside.as_ref().is_some_and(OutsidePart::takes_samples) {
            let mut plant = self.plant.build(&[], self.step_s)?;
            let (max_step_m, seed) =
                (self.options.limits.max_step_m, Seed(self.seed).child("samples"));
            tasks::policy_samples(plant.as_mut(), policy.as_mut(), max_step_m, seed)
                .map_err(|error| error.to_string())?;
        }
        Ok(Players { policy, plant: self.robot(&self.plant)? })
    }

    fn policy(
        &self,
        (networks, error): <PartHandles as StageInputs>::Results<'_>,
    ) -> Result<Box<dyn Policy>, String> {
        if let Some(outside) = &self.outside {
            return outside.build(self.plant.tendons(), &self.options);
        }
        let entry = policies::find(&self.policy)
            .ok_or_else(|| format!("unknown policy {}", self.policy))?;
        let mut parts = PolicyParts::default();
        for (network, trained) in entry.networks().zip(networks) {
            let trained = Arc::new(trained.network.clone());
            parts = parts.with_network(network, trained).map_err(|error| error.to_string())?;
        }
        if let Some(gp) = error {
            let tendons = gp.inputs().saturating_sub(3);
            parts = parts.with_error(Arc::new(
                GpError::new(gp.clone(), tendons).map_err(|error| error.to_string())?,
            ));
        }
        if let Some(model) = &self.model {
            parts = parts.with_layout(model.spec().tendon_layout());
            if entry.model == ModelAccess::AtRest {
                let tip = tasks::tip_model(model.spec())
                    .ok_or("a model without equations has no equilibrium tip position")?;
                parts = parts.with_tip_model(tip);
            }
        }
        policies::build(entry, parts, &self.options).map_err(|error| error.to_string())
    }
}

fn measured(target: usize, target_m: &Point3, outcome: ReachOutcome) -> ReachTrial {
    ReachTrial {
        error_m: outcome.error_m,
        steps: outcome.steps as u64,
        settled: outcome.settled,
        switches: outcome.switches as u64,
        ..ReachTrial::new(target as u64, *target_m, outcome.tip_m, outcome.status)
    }
}

fn track_sample(step: TrackStep) -> TrackSample {
    TrackSample {
        step: step.step as u64,
        time_s: step.time_s,
        path_point: step.path_point as u64,
        error_m: step.error_m,
        branch: step.branch.to_owned(),
        pulls_m: micrometres(&step.pulls_m),
        ..TrackSample::new(step.target_m, step.tip_m, step.status)
    }
}

/// Displacements in whole micrometres, separated by spaces, as text in metres.
fn micrometres(pulls_m: &[f64]) -> String {
    let each: Vec<String> =
        pulls_m.iter().map(|pull_m| ((pull_m * 1e6).round() / 1e6).to_string()).collect();
    each.join(" ")
}
