//! The inverse mapping trained on generated data.

use super::networks::NetworkParams;
use super::samples::{joined, simulated};
use crate::base::Seed;
use crate::learn::gp::Gp;
use crate::learn::rnn::{Elman, Trained};
use crate::policies::GpError;
use crate::runner::stage::{Handle, Stage, StageKind};
use crate::tasks::{self, Transitions};

/// Handles of the exploration, of the Gaussian process, of the network to start from (a new one where there is none)
/// and, where p_sim comes from it, of the forward network.
pub(in crate::runner) type GeneratedInputs =
    (Handle<Transitions>, Handle<Gp>, Option<Handle<Trained>>, Option<Handle<Trained>>);

/// The inverse mapping of eq. (24).
pub(in crate::runner) const GENERATED: Stage<NetworkParams, GeneratedInputs, Trained> = Stage {
    kind: StageKind { name: "train_inverse_b", module: module_path!(), cost_ms: 1000 },
    job: |params, (samples, gp, start, network)| {
        let error = GpError::new(gp.clone(), samples.pulls_m.width()).map_err(|error| error.to_string())?;
        let simulated = network.map(|network| simulated(network, samples)).transpose()?;
        let samples = tasks::correct_samples(simulated.as_ref().unwrap_or(samples), &error);
        let samples = samples.map_err(|error| error.to_string())?;
        let inputs = joined(&samples.from_m, &samples.to_m);
        let (outputs, starts, seed) = (&samples.pulls_m, &samples.starts, Seed(params.seed));
        let trained = match start {
            Some(start) => start.network.retrain(&inputs, outputs, starts, &params.config, seed),
            None => Elman::train(&inputs, outputs, starts, &params.config, seed),
        };
        trained.map_err(|error| error.to_string())
    },
};
