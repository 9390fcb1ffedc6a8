//! What was found out about a changed robot. A file of its own: what reads a diagnosis need not depend on how it is made.

use crate::effects::EffectSpec;
use serde::{Deserialize, Serialize};

/// The answer of a discovery.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(in crate::runner) struct Diagnosis {
    /// The verdict, or `failed` and why.
    pub(in crate::runner) verdict: String,
    /// The lines that the model gets.
    pub(in crate::runner) effects: Vec<EffectSpec>,
    /// Rows of the recording.
    pub(in crate::runner) samples: u64,
    /// Rms tip error of held-out trials before and after, metres.
    pub(in crate::runner) gap_m: [f64; 2],
    /// Rms distance of the measured from the true tip by noise alone, metres.
    pub(in crate::runner) noise_floor_m: f64,
}

impl Diagnosis {
    /// The answer of a recording of so many rows that adds nothing to the model.
    pub(in crate::runner) fn nothing(verdict: String, samples: u64) -> Diagnosis {
        Diagnosis { verdict, effects: Vec::new(), samples, gap_m: [f64::NAN; 2], noise_floor_m: f64::NAN }
    }
}
