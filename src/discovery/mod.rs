//! Discovery: find the effect of the catalogue that a model lacks, fit it, and test whether anything else is missing
//! (docs/discovery.md).
//!
//! Stages, each a sub-folder that imports only those above it: `recording` (samples and held-out trials), `fit` (one
//! candidate set), `mistakes` (faults of the recording), `noise_floor`, `problem`, `search` (over candidate sets), `goodness_of_fit` (are the residuals
//! noise), `next_experiment`, `answer` (verdict and text).
//!
//! Every candidate is fitted with the full physics. Parameters that a laboratory would recalibrate are nuisance
//! parameters of every candidate. Candidates pay for their parameters. Held-out trials are used in none of this.

mod answer;
mod error;
mod fit;
mod goodness_of_fit;
mod mistakes;
mod next_experiment;
mod noise_floor;
mod options;
mod problem;
mod recording;
mod search;
mod steps;

use crate::data::Recording;
use crate::effects::Model;

use answer::clock;
use answer::final_fit::FinalFit;
use answer::mistaken::mistaken;
use mistakes::mislabelled::Mistake;
use mistakes::{clock_offset, excluded_rows, mislabelled};
use noise_floor::NoiseFloor;
use noise_floor::trial_starts::scattered_starts;
use problem::Problem;
use recording::samples::Samples;
use search::{Search, SearchOutcome};
use steps::step;

pub use answer::Discovery;
pub use answer::alternatives::Alternatives;
pub use error::DiscoveryError;
pub use next_experiment::t_optimality::NextExperiment;
pub use options::{Options, Uncertainty};
pub use steps::telling_steps;

/// Finds the effect that `model` lacks to explain `measured`. With a `baseline`, a recording of the robot as built,
/// the model is first calibrated on it, and errors that both recordings share are not attributed to an effect. Every
/// trial starts at rest under the weight of its first row ([`Recording::check_loads`]); if the first tip positions
/// scatter too much for that, the first second of each trial is excluded.
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
    let excluded = excluded_rows::find(model, measured, options);
    let baseline_excluded = baseline.map(|baseline| excluded_rows::find(model, baseline, options));
    let kept_baseline = baseline.zip(baseline_excluded.as_ref()).map(|(baseline, rows)| {
        let kept = if rows.is_empty() { baseline.clone() } else { rows.without(baseline) };
        match clock_offset::find(model, &kept, options).filter(|offset| offset.is_one_step) {
            Some(offset) => kept.with_tips_later(offset.offset_s),
            None => kept,
        }
    });
    let kept = if excluded.is_empty() { measured.clone() } else { excluded.without(measured) };
    let told_mistake = |mistake: &Mistake| -> Result<Discovery, DiscoveryError> {
        let samples = Samples::new(&kept);
        recording::validate::check(&kept, &samples)?;
        recording::validate::check_trials(&samples)?;
        let simulated_m = problem::simulate_model(model, &samples)?;
        let mut told = mistaken(model, measured, (&samples, &simulated_m), mistake, options);
        excluded_rows::tell(&mut told.findings, (measured, &excluded), None);
        Ok(told)
    };
    if let Some(mistake) = mislabelled::find(model, &kept, options) {
        return told_mistake(&mistake);
    }
    step("comparing the clocks of commands and tips");
    // Trials that are cut from a run begin with motion whose commands are not in them: that is no clock.
    let begins_at_rest = scattered_starts(&Samples::new(&kept).starting(model.tracking.starts), model).is_none();
    let offset = begins_at_rest.then(|| clock_offset::find(model, &kept, options)).flatten();
    if let Some((offset, mistake)) = offset.and_then(|own| Some((own, own.mistake(model, &kept, options)?))) {
        let mut told = told_mistake(&mistake)?;
        offset.tell(&mut told.findings);
        return Ok(told);
    }
    let shifted = offset.map(|offset| kept.with_tips_later(offset.offset_s));
    let searched = shifted.as_ref().unwrap_or(&kept);
    let mut told = discover_in_kept(model, (measured, searched), kept_baseline.as_ref(), options)?;
    excluded_rows::tell(&mut told.findings, (measured, &excluded), baseline.zip(baseline_excluded.as_ref()));
    match offset {
        Some(offset) => {
            told.residuals.iter_mut().for_each(|row| row.time_s -= offset.offset_s);
            offset.tell(&mut told.findings);
            told.findings.limitations.push(offset.sentence());
        }
        None => clock::tell_delay(&mut told.findings),
    }
    Ok(told)
}

/// [`discover`] in the rows that are `kept` of `measured`.
fn discover_in_kept(
    model: &Model,
    (measured, kept): (&Recording, &Recording),
    baseline: Option<&Recording>,
    options: &Options,
) -> Result<Discovery, DiscoveryError> {
    let new_problem = |samples: Samples| -> Result<Problem, DiscoveryError> {
        recording::validate::check(kept, &samples)?;
        recording::validate::check_trials(&samples)?;
        step(if baseline.is_some() { "calibrating on the baseline" } else { "simulating the model" });
        let mut problem = Problem::new(model, samples, baseline, options)?;
        let fitted: Vec<u64> = problem.training.trials.iter().map(|trial| trial.number).collect();
        problem.base_matches_model = recording::base_markers::base_matches_model(measured, &fitted, model);
        Ok(problem)
    };
    let all = Samples::new(kept).starting(model.tracking.starts);
    let problem = new_problem(all.clone())?;
    // Try without trial starts first: a few wrong tip positions bias every fit.
    if let Some(starts) = scattered_starts(&problem.training, model)
        && let Ok(rest) = new_problem(noise_floor::trial_starts::without_starts(&all))
        && let Ok((final_fit, found)) = search_best(&rest)
        && NoiseFloor::of_residual(&final_fit.fine.fitted.nuisance_fit, &rest.training).is_exceeded_by(&starts)
    {
        let mut told = rest.discovery(model, measured, &final_fit, &found);
        told.findings.limitations.push(noise_floor::trial_starts::starts_caveat(&starts));
        return Ok(told);
    }
    let (final_fit, found) = search_best(&problem)?;
    step("testing what is left and proposing the next measurement");
    Ok(problem.discovery(model, measured, &final_fit, &found))
}

/// Searches for the best set, tests it, and returns its final fit with the search outcome.
fn search_best(problem: &Problem) -> Result<(FinalFit, SearchOutcome), DiscoveryError> {
    let fit_problem = problem.fit_problem();
    let cannot_follow = || DiscoveryError::CannotFollow(problem.training.trials[0].number);
    let limits = problem.options.limits(&problem.model, problem.model_form_m);
    let mut search = Search::new(&fit_problem, problem.sensitivities.clone(), &limits).ok_or_else(cannot_follow)?;
    step("trying the effects one by one");
    let mut best = search.greedy();
    let mut final_fit = problem.final_fit(&best.fitted);
    let mut searched = !final_fit.goodness.is_doubtful && best.fitted.members.is_empty();
    while !searched {
        let (before, certainly) = (best.fitted.members.clone(), final_fit.goodness.is_rejected());
        step("trying pairs of effects and larger amplitudes");
        best = search.widen(best, certainly);
        if best.fitted.members != before {
            final_fit = problem.final_fit(&best.fitted);
        }
        // `unexplained` requires that the exhaustive search has run.
        searched = certainly || !final_fit.goodness.is_rejected();
    }
    step("fitting the answer with full accuracy");
    let (best, final_fit) = problem.rescore(&mut search, best, final_fit);
    let found = final_fit.replace_best(search.into_outcome(best));
    Ok((final_fit, found))
}
