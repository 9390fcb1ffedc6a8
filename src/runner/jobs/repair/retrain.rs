//! Networks that are trained on from where they are, on data of a repaired model or of a new error
//! model.

use crate::base::Seed;
use crate::learn::gp::Gp;
use crate::learn::networks::Trained;
use crate::policies::GpError;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::learning::networks::{NetworkParams, columns};
use crate::tasks::{self, Transitions};

/// Handles of the network as it is, of the exploration, and for generated data of the error model.
type RetrainInputs = (Handle<Trained>, Handle<Transitions>, Option<Handle<Gp>>);

/// The training of a network from its present weights; its name is a parameter.
pub(crate) const RETRAIN: Stage<(String, NetworkParams), RetrainInputs, Trained> = Stage {
    kind: StageKind { name: "retrain", module: module_path!(), cost_ms: 1000 },
    job: |(_, params), (present, samples, gp)| {
        let generated = gp.map(|gp| generated(samples, gp)).transpose()?;
        let samples = generated.as_ref().unwrap_or(samples);
        let (inputs, outputs) = (columns(samples, params.inputs), columns(samples, params.outputs));
        let trained = present.network.retrain(
            &inputs,
            &outputs,
            &samples.starts,
            &params.config,
            Seed(params.seed),
        );
        trained.map_err(|error| error.to_string())
    },
};

/// The exploration as the robot would have done it (eq. 24).
fn generated(samples: &Transitions, gp: &Gp) -> Result<Transitions, String> {
    let error =
        GpError::new(gp.clone(), samples.pulls_m.width()).map_err(|error| error.to_string())?;
    tasks::correct_samples(samples, &error).map_err(|error| error.to_string())
}
