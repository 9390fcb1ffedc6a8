//! What was found out about a changed robot. A file of its own: what reads a diagnosis need not
//! depend on how it is made.

use crate::effects::EffectSpec;
use serde::{Deserialize, Serialize};

/// The answer of a discovery.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Diagnosis {
    /// The verdict, or `failed` and why.
    pub(crate) verdict: String,
    /// The lines that the model gets.
    pub(crate) effects: Vec<EffectSpec>,
    /// Rows of the recording.
    pub(crate) samples: u64,
    /// Rms tip error of held-out trials before and after, metres.
    pub(crate) gap_m: [f64; 2],
    /// Rms distance of the measured from the true tip by noise alone, metres.
    pub(crate) noise_floor_m: f64,
}

impl Diagnosis {
    /// The answer of a recording of so many rows that adds nothing to the model.
    pub(crate) fn nothing(verdict: String, samples: u64) -> Diagnosis {
        Diagnosis {
            verdict,
            effects: Vec::new(),
            samples,
            gap_m: [f64::NAN; 2],
            noise_floor_m: f64::NAN,
        }
    }
}
