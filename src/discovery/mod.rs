//! Discovery: find the effect of the catalogue that a model lacks, fit it, and test whether anything else is missing
//! (docs/discovery.md).
//!
//! Stages, each a sub-folder that imports only those above it: `recording` (samples and held-out trials), `fit` (one
//! candidate set), `mistakes` (faults of the recording), `noise_floor`, `problem`, `search` (over candidate sets),
//! `goodness_of_fit` (are the residuals noise), `next_experiment`, `answer` (verdict and text).
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
use answer::trial_by_trial::JudgedEffect;
use mistakes::clock_offset::ClockOffset;
use mistakes::mislabelled::Mistake;
use mistakes::{clock_offset, excluded_rows, mislabelled};
use noise_floor::NoiseFloor;
use noise_floor::trial_starts;
use noise_floor::trial_starts::scattered_starts;
use problem::Problem;
use recording::base_markers;
use recording::blocks;
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
        let offset = (!options.at_rest).then(|| clock_offset::find(model, &kept, options)).flatten();
        match offset.filter(|offset| offset.is_one_step) {
            Some(offset) => kept.with_tips_later(offset.offset_s),
            None => kept,
        }
    });
    let kept = if excluded.is_empty() { measured.clone() } else { excluded.without(measured) };
    let told_mistake = |mistake: &Mistake| -> Result<Discovery, DiscoveryError> {
        let samples = options.samples(model, &kept);
        recording::validate::check(&kept, &samples)?;
        recording::validate::check_trials(&samples)?;
        let simulated_m = problem::simulate_model(model, &samples)?;
        let mut told = mistaken(model, measured, (&samples, &simulated_m), mistake, options);
        excluded_rows::tell(&mut told.findings, (measured, &excluded), None);
        Ok(told)
    };
    let asked = Asked { model, measured, baseline: kept_baseline.as_ref(), options };
    let (mut told, offset) = match mislabelled::find(model, &kept, options) {
        None => asked.answer(&kept)?,
        Some(mistake) if !asked.doubts(&mistake) => return told_mistake(&mistake),
        Some(mistake) => match asked.answer(&kept) {
            Ok(answer) if answer.0.findings.gap.after_m < mistake.after_m => answer,
            _ => return told_mistake(&mistake),
        },
    };
    excluded_rows::tell(&mut told.findings, (measured, &excluded), baseline.zip(baseline_excluded.as_ref()));
    told.findings.limitations.extend(blocks::caveats(measured, options.playing(model)));
    match offset {
        Some(offset) => {
            told.residuals.iter_mut().for_each(|row| row.time_s -= offset.offset_s);
            offset.tell(&mut told.findings);
        }
        None => clock::tell_delay(&mut told.findings),
    }
    Ok(told)
}

/// The clock's offset is estimated so many times at most, until it changes by less than this, seconds.
const MOST_REFINEMENTS: usize = 4;
const SMALL_OFFSET_S: f64 = 2e-3;
/// A second start is later by so many standard deviations.
const LATER_START: f64 = 1.5;

/// What was given, without mistakes.
struct Asked<'a> {
    model: &'a Model,
    measured: &'a Recording,
    baseline: Option<&'a Recording>,
    options: &'a Options,
}

/// The rows that are searched, and their samples.
struct SearchedRows {
    recording: Recording,
    samples: Samples,
}

impl Asked<'_> {
    /// Whether effects may explain more than the `mistake`: with it the recording fits worse than the baseline by far, which
    /// was recorded in the same set-up.
    fn doubts(&self, mistake: &Mistake) -> bool {
        self.baseline.is_some_and(|baseline| mistake.is_doubtful(self.model, baseline, self.options))
    }

    /// The answer from the rows that are `kept`, without a mistake in them, and the offset of the tracker's clock.
    fn answer(&self, kept: &Recording) -> Result<(Discovery, Option<ClockOffset>), DiscoveryError> {
        let Asked { model, options, .. } = *self;
        step("comparing the clocks of commands and tips");
        // Trials that are cut from a run begin with motion whose commands are not in them: that is no clock.
        let begins_at_rest = || scattered_starts(&options.samples(model, kept), model).is_none();
        let offset = (!options.at_rest && begins_at_rest()).then(|| clock_offset::find(model, kept, options)).flatten();
        let offset = offset.map(|offset| self.refined(kept, offset)).transpose()?;
        Ok((self.discover_in_samples(&self.shifted(kept, offset))?, offset))
    }

    /// The rows that are `kept`, with every tip later by the `offset` of the tracker's clock.
    fn shifted(&self, kept: &Recording, offset: Option<ClockOffset>) -> SearchedRows {
        let recording = offset.map_or_else(|| kept.clone(), |offset| kept.with_tips_later(offset.offset_s));
        let samples = self.options.samples(self.model, &recording);
        let samples = match offset {
            Some(offset) => offset.uncertain_in(samples, self.model, kept, self.options),
            None => samples,
        };
        SearchedRows { recording, samples }
    }

    /// The `offset` beside the effects that a first search finds: effects that slow the robot bias an estimate without
    /// them towards earlier, so that a later start competes.
    fn refined(&self, kept: &Recording, offset: ClockOffset) -> Result<ClockOffset, DiscoveryError> {
        let Some(deviation_s) = offset.deviation_s() else { return Ok(offset) };
        let mut best = self.refined_from(kept, offset)?;
        let later = self.refined_from(kept, best.0.later(LATER_START * deviation_s))?;
        if later.1 > best.1 {
            best = later;
        }
        Ok(best.0)
    }

    /// The offset that a search from this one settles at, with the score there. Repeated until it stays, because the tip's
    /// response to the clock is only linear nearby.
    fn refined_from(&self, kept: &Recording, mut offset: ClockOffset) -> Result<(ClockOffset, f64), DiscoveryError> {
        let mut score = f64::NEG_INFINITY;
        for _ in 0..MOST_REFINEMENTS {
            let searched = self.shifted(kept, Some(offset));
            if searched.samples.clock_deviation_s.is_none() {
                break;
            }
            let problem = self.problem(&searched.recording, searched.samples)?;
            let fit_problem = problem.fit_problem();
            let limits = problem.options.limits(&problem.model, problem.model_form_m);
            let Some(mut search) = Search::new(&fit_problem, problem.sensitivities.clone(), &limits) else { break };
            let found = search.greedy();
            let more_s = found.fitted.nuisance_fit.amounts[problem.uncertain(&[]).clock_column()];
            // Scores are relative to the given model, which an offset changes.
            let given = fit_problem.evaluate_null().map_or(f64::INFINITY, |null| null.nuisance_fit.deviance);
            score = found.score - given;
            offset = offset.later(more_s);
            if more_s.abs() < SMALL_OFFSET_S {
                break;
            }
        }
        Ok((offset, score))
    }

    fn problem(&self, kept: &Recording, samples: Samples) -> Result<Problem<'_>, DiscoveryError> {
        recording::validate::check(kept, &samples)?;
        recording::validate::check_trials(&samples)?;
        step(if self.baseline.is_some() { "calibrating on the baseline" } else { "simulating the model" });
        let mut problem = Problem::new(self.model, samples, self.baseline, self.options)?;
        let fitted = problem.training.recorded_rows();
        problem.base_matches_model = base_markers::base_matches_model(kept, &fitted, self.model);
        Ok(problem)
    }

    /// The answer from these samples.
    fn discover_in_samples(&self, searched: &SearchedRows) -> Result<Discovery, DiscoveryError> {
        let problem = self.problem(&searched.recording, searched.samples.clone())?;
        // Try without trial starts first: a few wrong tip positions bias every fit.
        if let Some(starts) = scattered_starts(&problem.training, self.model)
            && let Ok(rest) = self.problem(&searched.recording, trial_starts::without_starts(&searched.samples))
            && let Ok((final_fit, found)) = search_best(&rest)
            && NoiseFloor::of_residual(&final_fit.fine.fitted.nuisance_fit, &rest.training).is_exceeded_by(&starts)
        {
            let mut told = rest.discovery(self.model, self.measured, &final_fit, &found);
            told.findings.limitations.push(trial_starts::starts_caveat(&starts));
            return Ok(told);
        }
        let (final_fit, found) = search_best(&problem)?;
        step("testing what is left and proposing the next measurement");
        Ok(problem.discovery(self.model, self.measured, &final_fit, &found))
    }
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
    let judged = if best.fitted.members.is_empty() { problem.judge_by_trials(&search) } else { None };
    if let Some(JudgedEffect { best, final_fit, evidence }) = judged {
        let found = final_fit.replace_best(search.into_outcome(best));
        return Ok((final_fit, SearchOutcome { by_trials: Some(evidence), ..found }));
    }
    let found = final_fit.replace_best(search.into_outcome(best));
    Ok((final_fit, found))
}
