//! The stages of a discovery in their order, from prepared recordings to the evidence for the
//! answer.

use super::answer::evidence::Evidence;
use super::answer::final_fit::FinalFit;
use super::error::DiscoveryError;
use super::mistakes::clock_offset::{self, ClockOffset};
use super::mistakes::excluded_rows::PreparedRecording;
use super::mistakes::mislabelled::Mistake;
use super::noise_floor::NoiseFloor;
use super::noise_floor::trial_starts::{scattered_starts, starts_caveat, without_starts};
use super::options::Options;
use super::problem::Problem;
use super::recording::{base_markers, samples::Samples, validate};
use super::search::{Search, SearchOutcome};
use super::steps::step;
use crate::data::Recording;
use crate::effects::Model;

/// The offset of the tracker's clock is estimated this many times at most, until it changes by less
/// than the tolerance.
const MAX_CLOCK_REFINEMENTS: usize = 4;
const CLOCK_TOLERANCE_S: f64 = 2e-3;
/// The second start of the refinement is later by so many standard deviations. Two recordings with
/// a load settled 0.03 s early without it (docs/method/search.md, "Mistakes before physics").
const LATER_START_SIGMA: f64 = 1.5;

/// The stages, with what they have in common.
pub(super) struct DiscoveryStages<'a> {
    /// The model as given.
    pub(super) model: &'a Model,
    pub(super) measured: &'a PreparedRecording<'a>,
    pub(super) baseline: Option<&'a PreparedRecording<'a>>,
    pub(super) options: &'a Options,
}

/// The recording that is searched, and its samples.
struct SearchedRecording {
    recording: Recording,
    samples: Samples,
}

/// An offset of the tracker's clock with the score of the best set there.
struct ScoredOffset {
    offset: ClockOffset,
    score: f64,
}

impl<'a> DiscoveryStages<'a> {
    /// Whether effects may explain more than the `mistake`: with it, the recording fits far worse
    /// than the baseline, which was recorded in the same set-up.
    pub(super) fn doubts(&self, mistake: &Mistake) -> bool {
        self.baseline.is_some_and(|baseline| {
            !mistake.of_baseline && mistake.is_doubtful(self.model, &baseline.samples, self.options)
        })
    }

    /// The evidence of a recording with a mistake in it. No effect is sought.
    pub(super) fn mistaken(&self, mistake: Mistake) -> Result<Evidence, DiscoveryError> {
        validate::check_measured(&self.measured.kept, &self.measured.samples)?;
        Evidence::of_mistake(self.model, self.measured, mistake, self.options)
    }

    /// The evidence of a search for effects, in a recording without a mistake.
    pub(super) fn search(&self) -> Result<Evidence, DiscoveryError> {
        step("comparing the clocks of commands and tips");
        let PreparedRecording { kept, samples, .. } = self.measured;
        // Trials cut from a longer run start in motion, whose commands are not recorded. That
        // imitates a clock offset.
        let has_times = !self.options.at_rest && scattered_starts(samples, self.model).is_none();
        let offset =
            has_times.then(|| clock_offset::find(self.model, kept, self.options)).flatten();
        let clock = offset.map(|offset| self.refined(offset)).transpose()?;
        let evidence = self.search_at(&self.shifted(clock))?;
        Ok(Evidence { clock, ..evidence })
    }

    /// The measured recording with every tip later by the `offset` of the tracker's clock.
    fn shifted(&self, offset: Option<ClockOffset>) -> SearchedRecording {
        let PreparedRecording { kept, samples, .. } = self.measured;
        let Some(offset) = offset else {
            return SearchedRecording { recording: kept.clone(), samples: samples.clone() };
        };
        let recording = kept.with_tips_later(offset.offset_s);
        let samples = self.options.samples(self.model, &recording);
        let samples = offset.uncertain_in(samples, self.model, kept, self.options);
        SearchedRecording { recording, samples }
    }

    /// The `offset` beside the effects that a search names. Effects that slow the robot bias an
    /// estimate without them towards earlier, so a later start competes and the better score
    /// decides.
    fn refined(&self, offset: ClockOffset) -> Result<ClockOffset, DiscoveryError> {
        let Some(deviation_s) = offset.deviation_s() else { return Ok(offset) };
        let first = self.refined_from(offset)?;
        let later = self.refined_from(first.offset.later(LATER_START_SIGMA * deviation_s))?;
        Ok(if later.score > first.score { later.offset } else { first.offset })
    }

    /// The offset at which searches that start from this one settle. The tip responds to the clock
    /// linearly only nearby, so the estimate is repeated until it stays.
    fn refined_from(&self, mut offset: ClockOffset) -> Result<ScoredOffset, DiscoveryError> {
        let mut score = f64::NEG_INFINITY;
        for _ in 0..MAX_CLOCK_REFINEMENTS {
            let searched = self.shifted(Some(offset));
            if searched.samples.clock_deviation_s.is_none() {
                break;
            }
            let problem = self.problem(&searched.recording, searched.samples)?;
            let fit_problem = problem.fit_problem();
            let Some(mut search) =
                Search::new(&fit_problem, problem.sensitivities.clone(), &problem.limits())
            else {
                break;
            };
            // Effects and clock are estimated together, since each imitates the other.
            let best = search.grow(search.null.clone());
            let change_s = best.fitted.nuisance_fit.amounts[problem.uncertain(&[]).clock_column()];
            // Scores are relative to the given model, whose deviance changes with the offset.
            score = best.score - search.null.fitted.nuisance_fit.deviance;
            offset = offset.later(change_s);
            if change_s.abs() < CLOCK_TOLERANCE_S {
                break;
            }
        }
        Ok(ScoredOffset { offset, score })
    }

    fn problem(
        &self,
        recording: &Recording,
        samples: Samples,
    ) -> Result<Problem<'a>, DiscoveryError> {
        validate::check_measured(recording, &samples)?;
        step(if self.baseline.is_some() {
            "calibrating on the baseline"
        } else {
            "simulating the model"
        });
        let mut problem = Problem::new(self.model, samples, self.baseline, self.options)?;
        let fitted_rows = problem.training.recorded_rows();
        problem.base_matches_model =
            base_markers::base_matches_model(recording, &fitted_rows, self.model);
        Ok(problem)
    }

    /// The evidence from these samples.
    fn search_at(&self, searched: &SearchedRecording) -> Result<Evidence, DiscoveryError> {
        let problem = self.problem(&searched.recording, searched.samples.clone())?;
        // Try without trial starts first: a few wrong tip positions bias every fit.
        if let Some(starts) = scattered_starts(&problem.training, self.model)
            && let Ok(later) = self.problem(&searched.recording, without_starts(&searched.samples))
            && let Ok((final_fit, outcome)) = search_best(&later)
            && NoiseFloor::of_residual(&final_fit.fine.fitted.nuisance_fit, &later.training)
                .is_exceeded_by(&starts)
        {
            let mut evidence = later.evidence(self.measured.original, &final_fit, &outcome);
            evidence.limitations.push(starts_caveat(&starts));
            return Ok(evidence);
        }
        let (final_fit, outcome) = search_best(&problem)?;
        step("testing the residual and proposing the next measurement");
        Ok(problem.evidence(self.measured.original, &final_fit, &outcome))
    }
}

/// Searches for the best set, tests it, and returns its final fit with the search outcome.
fn search_best(problem: &Problem) -> Result<(FinalFit, SearchOutcome), DiscoveryError> {
    let fit_problem = problem.fit_problem();
    let cannot_follow = || DiscoveryError::CannotFollow(problem.training.trials[0].number);
    let mut search = Search::new(&fit_problem, problem.sensitivities.clone(), &problem.limits())
        .ok_or_else(cannot_follow)?;
    step("trying the effects one by one");
    let mut best = search.grow(search.null.clone());
    let mut final_fit = problem.final_fit(&best.fitted);
    let mut is_searched = !final_fit.goodness.is_doubtful && best.fitted.members.is_empty();
    // A set that a test rejects or doubts is searched again, more widely each time.
    while !is_searched {
        let (members, is_rejected) =
            (best.fitted.members.clone(), final_fit.goodness.failed.is_some());
        step("trying pairs of effects and larger amplitudes");
        best = search.widen(best, is_rejected);
        if best.fitted.members != members {
            final_fit = problem.final_fit(&best.fitted);
        }
        // `unexplained` requires that the exhaustive search has run.
        is_searched = is_rejected || final_fit.goodness.failed.is_none();
    }
    step("fitting the answer with full accuracy");
    let (best, final_fit) = problem.rescore(&mut search, best, final_fit);
    // Where the search names nothing, single trials may still show one effect.
    let judged =
        if best.fitted.members.is_empty() { problem.judge_by_trials(&search) } else { None };
    Ok(match judged {
        Some(judged) => {
            let outcome = judged.final_fit.replace_best(search.into_outcome(judged.best));
            (judged.final_fit, SearchOutcome { by_trials: Some(judged.evidence), ..outcome })
        }
        None => {
            let outcome = final_fit.replace_best(search.into_outcome(best));
            (final_fit, outcome)
        }
    })
}
