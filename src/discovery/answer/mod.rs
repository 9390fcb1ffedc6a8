//! From the search outcome to the answer: final fit, evidence, verdict, findings.

pub(crate) mod alternatives;
pub(crate) mod candidates;
pub(crate) mod caveats;
pub(crate) mod evidence;
pub(crate) mod explained_share;
pub(crate) mod final_fit;
pub(crate) mod findings;
pub(crate) mod held_out_check;
pub(crate) mod mistaken;
pub(crate) mod named_effects;
pub(crate) mod rescore;
pub(crate) mod residual_map;
pub(crate) mod summary_text;
pub(crate) mod trial_by_trial;
pub(crate) mod verdict;

use crate::data::findings::{Findings, PlaceRow, ResidualRow};
use crate::discovery::next_experiment::t_optimality::NextExperiment;
use crate::effects::Model;
use alternatives::Alternatives;

/// Result of a discovery.
#[derive(Clone, Debug)]
pub struct Discovery {
    /// The findings, as in `findings.json`.
    pub findings: Findings,
    /// The given model (calibrated, if there was a baseline) with the named effects.
    pub model: Model,
    /// Every sample with its residual before and after.
    pub residuals: Vec<ResidualRow>,
    /// The residual map.
    pub places: Vec<PlaceRow>,
    /// Held-out errors of alternatives to naming the effect.
    pub alternatives: Alternatives,
    /// Proposed experiments if the verdict is `ambiguous`, best first.
    pub next_experiments: Vec<NextExperiment>,
    /// Whether calibration on the baseline changed the model.
    pub calibrated: bool,
}
