//! Discovery: where a model and a measurement disagree, which effect of the catalogue is missing, how much of it, and
//! whether that is all (docs/discovery.md).
//!
//! The physics is fitted anew for every candidate; numbers that a lab would recalibrate are free in all of them alike;
//! candidates pay for their parameters; trials that take no part in any of it are the proof.

mod answer;
mod error;
mod fit;
mod goodness_of_fit;
mod next_experiment;
mod noise_floor;
mod options;
mod problem;
mod recording;
mod search;

use crate::data::Recording;
use crate::data::findings::{Findings, PlaceRow, ResidualRow};
use crate::effects::Model;

use answer::final_fit::About;
use noise_floor::Floor;
use problem::Question;
use recording::samples::Samples;
use search::{Found, Search};

pub use answer::alternatives::Remedies;
pub use error::DiscoveryError;
pub use next_experiment::t_optimality::Next;
pub use options::{Options, Uncertainty};

/// An answer with all that stands behind it.
#[derive(Clone, Debug)]
pub struct Discovery {
    /// The answer.
    pub findings: Findings,
    /// The given model (calibrated, where there was a baseline) with the effects that were named.
    pub model: Model,
    /// Every sample that was asked about with its residual before and after.
    pub residuals: Vec<ResidualRow>,
    /// The map of disagreement.
    pub places: Vec<PlaceRow>,
    /// What a lab would try instead.
    pub remedies: Remedies,
    /// What to record next where these data cannot tell, the best first.
    pub next: Vec<Next>,
    /// Whether a baseline has changed the model that all of this is about.
    pub calibrated: bool,
}

/// Finds what `model` lacks to explain `measured`. With a `baseline`, a recording of the robot as built, the model is
/// first calibrated on it, and what the two have in common is no discovery. Every trial starts at rest under its first
/// row's weight ([`Recording::check_loads`]); where first tips scatter too much for that, the
/// beginnings of trials are left out.
///
/// # Errors
/// [`DiscoveryError`] for data that allow no answer.
pub fn discover(
    model: &Model,
    measured: &Recording,
    baseline: Option<&Recording>,
    options: &Options,
) -> Result<Discovery, DiscoveryError> {
    options.check()?;
    let ask = |samples: Samples| -> Result<Question, DiscoveryError> {
        recording::validate::check(measured, &samples)?;
        recording::validate::check_trials(&samples)?;
        let mut question = Question::new(model, samples, baseline, options)?;
        let fitted: Vec<u64> = question.fit.trials.iter().map(|trial| trial.number).collect();
        question.base_stands = recording::base_markers::stands_as_modelled(measured, &fitted, model);
        Ok(question)
    };
    let all = Samples::new(measured);
    let question = ask(all.clone())?;
    // Without them first, where that can be asked: a few tips that are far off lead every fit astray.
    if let Some(starts) = noise_floor::trial_starts::doubtful(&question.fit, model)
        && let Ok(rest) = ask(noise_floor::trial_starts::without(&all))
        && let Ok((about, found)) = searched(&rest)
        && Floor::left_by(&about.fine.fitted.explained, &rest.fit).is_exceeded_by(&starts)
    {
        let mut told = rest.discovery(model, measured, &about, &found);
        told.findings.limitations.push(noise_floor::trial_starts::left_out(&starts));
        return Ok(told);
    }
    let (about, found) = searched(&question)?;
    Ok(question.discovery(model, measured, &about, &found))
}

/// The best set of effects with all about it, and what else was found.
fn searched(question: &Question) -> Result<(About, Found), DiscoveryError> {
    let study = question.study();
    let unplayable = || DiscoveryError::Unplayable(question.fit.trials[0].number);
    let limits = question.options.limits(&question.model);
    let mut search = Search::new(&study, question.responses.clone(), &limits).ok_or_else(unplayable)?;
    let mut best = search.best();
    let mut about = question.about(&best.fitted);
    let mut searched = !about.left.possibly && best.fitted.members.is_empty();
    while !searched {
        let (before, certainly) = (best.fitted.members.clone(), about.left.certainly());
        best = search.thoroughly(best, certainly);
        if best.fitted.members != before {
            about = question.about(&best.fitted);
        }
        // Before anything is called unexplained, the search has known that something is left.
        searched = certainly || !about.left.certainly();
    }
    let (best, about) = question.judged(&mut search, best, about);
    let found = about.refined(search.ended(best));
    Ok((about, found))
}
