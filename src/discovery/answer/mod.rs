//! From the search to the answer: final fit, verdict, alternatives, residual map and text.

pub(crate) mod alternatives;
pub(crate) mod assemble;
pub(crate) mod caveats;
pub(crate) mod final_fit;
pub(crate) mod rescore;
pub(crate) mod residual_map;
pub(crate) mod summary_text;
pub(crate) mod verdict;

use crate::data::findings::{Findings, PlaceRow, ResidualRow};
use crate::discovery::next_experiment::t_optimality::NextExperiment;
use crate::effects::Model;
use alternatives::Alternatives;

/// An answer with all that stands behind it.
#[derive(Clone, Debug)]
pub struct Discovery {
    /// The answer.
    pub findings: Findings,
    /// The given model (calibrated, where there was a baseline) with the effects that were named.
    pub model: Model,
    /// Every sample that was asked final_fit with its residual before and after.
    pub residuals: Vec<ResidualRow>,
    /// The map of disagreement.
    pub places: Vec<PlaceRow>,
    /// What a lab would try instead.
    pub alternatives: Alternatives,
    /// What to record next where these data cannot tell, the best first.
    pub next_experiments: Vec<NextExperiment>,
    /// Whether a baseline has changed the model that all of this is final_fit.
    pub calibrated: bool,
}
