//! Discovery: find the effect of the catalogue that a model lacks, fit it, and test whether
//! anything else is missing (docs/method/search.md).
//!
//! The way of a measured tip: `recording` (samples and held-out trials), `fit` (one candidate set),
//! `mistakes` (faults of the recording), `noise_floor`, `problem`, `search` (over candidate sets),
//! `goodness_of_fit` (are the residuals noise), `next_experiment`, `answer`. Each is a sub-folder
//! that imports only those before it. `stages` calls them in this order and collects their
//! evidence; `answer/verdict.rs` decides the verdict from it and `answer/findings.rs` makes the
//! findings. `rounds` asks again with the recording that an ambiguous answer proposes.
//! `linear_problem` gives what methods of comparison need.
//!
//! Every candidate is fitted with the full physics. Parameters that a laboratory would recalibrate
//! are nuisance parameters of every candidate. Candidates pay for their parameters. Held-out trials
//! are used in none of this.

mod answer;
mod error;
mod fit;
mod goodness_of_fit;
mod linear_problem;
mod mistakes;
mod next_experiment;
mod noise_floor;
mod options;
mod problem;
mod recording;
mod rounds;
mod search;
mod stages;
mod steps;

use crate::data::Recording;
use crate::data::findings::Verdict;
use crate::effects::Model;

use mistakes::excluded_rows::PreparedRecording;
use mistakes::mislabelled;
use stages::DiscoveryStages;
use steps::step;

pub use answer::Discovery;
pub use answer::alternatives::Alternatives;
pub use error::DiscoveryError;
pub use linear_problem::{LinearProblem, LinearRows, linear_problem};
pub use next_experiment::t_optimality::NextExperiment;
pub use options::{Options, Uncertainty};
pub use rounds::{Question, Round, Rounds, RoundsError, discover_until_named};
pub use steps::with_step_listener;

/// Finds the effect that `model` lacks to explain `measured`. With a `baseline`, a recording of the
/// robot as built, the model is first calibrated on it, and errors that both recordings share are
/// not attributed to an effect. Every trial starts at rest under the weight of its first row
/// ([`Recording::check_loads`]); if the first tip positions scatter too much for that, the first
/// second of each trial is excluded.
///
/// # Errors
/// [`DiscoveryError`] if the data allow no answer.
pub fn discover(
    model: &Model,
    measured: &Recording,
    baseline: Option<&Recording>,
    options: &Options,
) -> Result<Discovery, DiscoveryError> {
    options.check()?;
    step("checking the recording");
    let measured = &PreparedRecording::new(model, measured, options);
    let baseline = baseline
        .map(|baseline| PreparedRecording::new(model, baseline, options).in_step(model, options));
    let stages = DiscoveryStages { model, measured, baseline: baseline.as_ref(), options };
    let evidence = match mislabelled::find_first(model, measured, baseline.as_ref(), options) {
        None => {
            let evidence = stages.search()?;
            let is_open = evidence.decision.verdict != Verdict::Consistent;
            let possible = is_open.then(|| mislabelled::find_possible(model, measured, options));
            match possible.flatten() {
                Some(mistake) => evidence.beside(mistake),
                None => evidence,
            }
        }
        Some(mistake) if !stages.doubts(&mistake) => stages.mistaken(mistake)?,
        // Effects may explain a doubtful mistake better. Held-out trials decide between the two.
        Some(mistake) => match stages.search() {
            Ok(evidence) if evidence.gap.after_m < mistake.after_m => evidence.beside(mistake),
            _ => stages.mistaken(mistake)?,
        },
    };
    Ok(evidence.into_discovery(measured, baseline.as_ref(), options.playing(model)))
}
