//! The answer to a blind case: of the model, the recording and the options alone.

use crate::benchmark::{CaseAnswer, PublicCase};
use crate::discovery::{Options, discover};
use crate::effects::Model;
use crate::runner::stage::{Handle, Stage, StageKind};

/// The answer, from the model and the options.
pub(in crate::runner) const DISCOVER: Stage<(Model, Options), Handle<PublicCase>, CaseAnswer> = Stage {
    kind: StageKind { name: "discover", module: module_path!(), cost_ms: 15_000 },
    job: |(model, options), presented| {
        let mut options = options.clone();
        options.left_out.extend(presented.left_out.iter().cloned());
        let found = discover(model, &presented.recording(), None, &options).map_err(|error| error.to_string())?;
        Ok(CaseAnswer::new(&found.findings, found.alternatives.stiffness_only_m, found.alternatives.gp_m))
    },
};
