//! Networks trained on recordings, as policies describe them.

use crate::base::{Rows, Seed};
use crate::learn::networks::{Network, NetworkConfig, Trained};
use crate::policies::{NetworkDescription, SampleColumns};
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::data::samples::joined;
use crate::tasks::Transitions;

/// The training of a network on the exploration, or on what the robot did under the same commands.
pub(crate) fn train(
    network: &NetworkDescription,
) -> Stage<NetworkParams, Handle<Transitions>, Trained> {
    Stage {
        kind: StageKind { name: network.stage, module: module_path!(), cost_ms: 1000 },
        job: |params, samples| {
            let limited = params.points.map(|points| samples.first(points));
            let samples = limited.as_ref().unwrap_or(samples);
            let (inputs, outputs) =
                (columns(samples, params.inputs), columns(samples, params.outputs));
            let trained = Network::train(
                &inputs,
                &outputs,
                &samples.starts,
                &params.config,
                Seed(params.seed),
            );
            trained.map_err(|error| error.to_string())
        },
    }
}

/// Parameters of a network.
#[derive(serde::Serialize)]
pub(crate) struct NetworkParams {
    pub(crate) config: NetworkConfig,
    pub(crate) inputs: &'static [SampleColumns],
    pub(crate) outputs: &'static [SampleColumns],
    /// How many of the samples it is trained on; all without a number.
    pub(crate) points: Option<usize>,
    pub(crate) seed: u64,
}

/// Some columns of samples, side by side.
pub(crate) fn columns(samples: &Transitions, chosen: &[SampleColumns]) -> Rows {
    let column = |columns: &SampleColumns| match columns {
        SampleColumns::Pulls => &samples.pulls_m,
        SampleColumns::TipBefore => &samples.from_m,
        SampleColumns::TipAfter => &samples.to_m,
    };
    let mut all = chosen.iter().map(column);
    let first = all.next().cloned().unwrap_or_default();
    all.fold(first, |rows, next| joined(&rows, next))
}
