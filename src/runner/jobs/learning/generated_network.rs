//! Networks trained on generated data.

use super::networks::{NetworkParams, columns};
use crate::base::Seed;
use crate::learn::gp::Gp;
use crate::learn::networks::{Network, Trained};
use crate::policies::{GpError, NetworkDescription};
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::data::samples::simulated;
use crate::tasks::{self, Transitions};

/// Handles of the exploration, of the Gaussian process, of the network to start from (a new one
/// where there is none) and, where p_sim comes from it, of the forward network.
pub(crate) type GeneratedInputs =
    (Handle<Transitions>, Handle<Gp>, Option<Handle<Trained>>, Option<Handle<Trained>>);

/// The training of a network on the exploration, moved by the error model (eq. 24).
pub(crate) fn train_generated(
    network: &NetworkDescription,
) -> Stage<NetworkParams, GeneratedInputs, Trained> {
    Stage {
        kind: StageKind { name: network.stage, module: module_path!(), cost_ms: 1000 },
        job: |params, (samples, gp, start, network)| {
            let error = GpError::new(gp.clone(), samples.pulls_m.width())
                .map_err(|error| error.to_string())?;
            let simulated = network.map(|network| simulated(network, samples)).transpose()?;
            let samples = tasks::correct_samples(simulated.as_ref().unwrap_or(samples), &error);
            let samples = samples.map_err(|error| error.to_string())?;
            let (inputs, outputs) =
                (columns(&samples, params.inputs), columns(&samples, params.outputs));
            let (starts, seed) = (&samples.starts, Seed(params.seed));
            let trained = match start {
                Some(start) => {
                    start.network.retrain(&inputs, &outputs, starts, &params.config, seed)
                }
                None => Network::train(&inputs, &outputs, starts, &params.config, seed),
            };
            trained.map_err(|error| error.to_string())
        },
    }
}
