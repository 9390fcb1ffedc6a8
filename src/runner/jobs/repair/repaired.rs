//! The exploration on a model with the lines that a diagnosis adds to it.

use super::diagnosis::Diagnosis;
use crate::base::Seed;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::data::exploration::ExploreParams;
use crate::tasks::{self, Transitions};

/// The exploration on the repaired model.
pub(crate) const EXPLORE_REPAIRED: Stage<ExploreParams, Handle<Diagnosis>, Transitions> = Stage {
    kind: StageKind { name: "collect_repaired", module: module_path!(), cost_ms: 14_000 },
    job: |params, diagnosis| {
        let mut plant = params.model.build(&diagnosis.effects, params.step_s)?;
        tasks::explore(plant.as_mut(), &params.options, Seed(params.seed))
            .map_err(|error| error.to_string())
    },
};
