//! What a model does with the lines that diagnoses add to it: the exploration, and the predefined points of the error model.

use super::diagnosis::Diagnosis;
use super::exploration::ExploreParams;
use super::identified::Identified;
use crate::base::Seed;
use crate::effects::EffectSpec;
use crate::runner::stage::{Handle, Stage, StageKind};
use crate::tasks::{self, GpPool, Transitions};

/// The exploration on the model with all lines.
pub(in crate::runner) const EXPLORE_REPAIRED: Stage<ExploreParams, Vec<Handle<Diagnosis>>, Transitions> = Stage {
    kind: StageKind { name: "collect_repaired", module: module_path!(), cost_ms: 14_000 },
    job: |params, diagnoses| {
        let mut plant = params.model.build(&lines(&diagnoses), params.step_s)?;
        tasks::explore(plant.as_mut(), &params.options, Seed(params.seed)).map_err(|error| error.to_string())
    },
};

/// Handles of the predefined points and of the diagnoses.
type PointInputs = (Handle<GpPool>, Vec<Handle<Diagnosis>>);

/// The commands of the predefined points on such a model: the model, and the duration of a step in seconds.
pub(in crate::runner) const POINTS_REPAIRED: Stage<(Identified, f64), PointInputs, Transitions> = Stage {
    kind: StageKind { name: "points_repaired", module: module_path!(), cost_ms: 2000 },
    job: |(model, step_s), (pool, diagnoses)| {
        let mut plant = model.build(&lines(&diagnoses), *step_s)?;
        tasks::replay(plant.as_mut(), &pool.steps, Seed(0)).map_err(|error| error.to_string())
    },
};

fn lines(diagnoses: &[&Diagnosis]) -> Vec<EffectSpec> {
    diagnoses.iter().flat_map(|diagnosis| diagnosis.effects.iter().cloned()).collect()
}
