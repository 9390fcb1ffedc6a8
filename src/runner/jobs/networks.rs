//! Networks trained on recordings.

use super::samples::joined;
use crate::base::Seed;
use crate::learn::rnn::{Elman, ElmanConfig, Trained};
use crate::runner::stage::{Handle, Stage, StageKind};
use crate::tasks::Transitions;

/// The forward model of eq. (17): (u_i, x_i) → x_{i+1}.
pub(in crate::runner) const FORWARD: Stage<NetworkParams, Handle<Transitions>, Trained> = Stage {
    kind: StageKind { name: "train_forward", module: module_path!(), cost_ms: 2000 },
    job: |params, samples| {
        let inputs = joined(&samples.pulls_m, &samples.from_m);
        let trained = Elman::train(&inputs, &samples.to_m, &samples.starts, &params.config, Seed(params.seed));
        trained.map_err(|error| error.to_string())
    },
};

/// The inverse mapping of eq. (21) from simulated data: (x_i, x_{i+1}) → u_i.
pub(in crate::runner) const INVERSE: Stage<NetworkParams, Handle<Transitions>, Trained> = Stage {
    kind: StageKind { name: "train_inverse", module: module_path!(), cost_ms: 1000 },
    job: |params, samples| train_inverse(params, samples),
};

/// The inverse mapping from the first real data (π_real): their number and the network.
pub(in crate::runner) const REAL: Stage<(usize, NetworkParams), Handle<Transitions>, Trained> = Stage {
    kind: StageKind { name: "train_pi_real", module: module_path!(), cost_ms: 1000 },
    job: |(points, params), samples| train_inverse(params, &samples.first(*points)),
};

/// Parameters of a network.
#[derive(serde::Serialize)]
pub(in crate::runner) struct NetworkParams {
    pub(in crate::runner) config: ElmanConfig,
    pub(in crate::runner) seed: u64,
}

fn train_inverse(params: &NetworkParams, samples: &Transitions) -> Result<Trained, String> {
    let inputs = joined(&samples.from_m, &samples.to_m);
    let trained = Elman::train(&inputs, &samples.pulls_m, &samples.starts, &params.config, Seed(params.seed));
    trained.map_err(|error| error.to_string())
}
