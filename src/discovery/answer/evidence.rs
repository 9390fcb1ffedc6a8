//! The evidence of all stages, from which the findings are made.

use super::alternatives::Alternatives;
use super::candidates::set_name;
use super::caveats::BaselineError;
use super::explained_share::ExplainedShare;
use super::final_fit::{FinalFit, FineFit};
use super::held_out_check::HeldOutCheck;
use super::named_effects::{NamedEffects, Rival};
use super::residual_map::{self, residual_map};
use super::summary_text::{self, BaselineShare};
use super::verdict::{Decision, HeldOutResult, SetEvidence, VerdictEvidence, decide};
use crate::data::Recording;
use crate::data::findings::{
    Candidate, FoundEffect, Gap, MissingTest, PlaceRow, ResidualRow, Verdict,
};
use crate::discovery::fit::ar1_noise::{Ar1Noise, MIN_SIGMA_M};
use crate::discovery::fit::candidate::effect_specs;
use crate::discovery::fit::gauss_newton::FitProblem;
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::mistakes::clock_offset::ClockOffset;
use crate::discovery::mistakes::mislabelled::Mistake;
use crate::discovery::next_experiment::t_optimality::NextExperiment;
use crate::discovery::noise_floor::NoiseFloor;
use crate::discovery::problem::Problem;
use crate::discovery::recording::covariates::sample_covariates;
use crate::discovery::recording::samples::{Samples, rms_m};
use crate::discovery::recording::validate;
use crate::discovery::search::SearchOutcome;
use crate::effects::{EffectSpec, Model};

/// What the stages report of a recording.
pub(crate) struct Evidence {
    pub(crate) decision: Decision,
    /// The mistake of the recording, if the answer is one.
    pub(crate) mistake: Option<Mistake>,
    /// A mistake that would explain most of a gap that nothing else explains.
    pub(crate) possible_mistake: Option<Mistake>,
    /// The error of the model on the baseline, if it is unusually large.
    pub(crate) baseline_error: Option<BaselineError>,
    /// The offset of the tracker's clock by which the tips were shifted.
    pub(crate) clock: Option<ClockOffset>,
    pub(crate) gap: Gap,
    /// What the errors are.
    pub(crate) error_name: &'static str,
    /// Rms held-out error beyond what the model leaves on this robot anyway, metres.
    pub(crate) left_m: f64,
    pub(crate) model_form_m: f64,
    pub(crate) residuals: ResidualEvidence,
    pub(crate) limitations: Vec<String>,
    pub(crate) search: SearchEvidence,
    /// The model with the named effects.
    pub(crate) model: Model,
}

/// The residuals before and after, and what remains in them.
pub(crate) struct ResidualEvidence {
    pub(crate) noise: Ar1Noise,
    /// Sources of the noise.
    pub(crate) noise_from: String,
    /// Whether nothing was measured repeatedly, so that the noise is less than this.
    pub(crate) noise_is_bound: bool,
    pub(crate) rows: Vec<ResidualRow>,
    pub(crate) places: Vec<PlaceRow>,
    pub(crate) missing_before: MissingTest,
    pub(crate) missing_after: MissingTest,
    /// Pattern of what remains.
    pub(crate) pattern: String,
}

/// What only a search for effects reports.
#[derive(Default)]
pub(crate) struct SearchEvidence {
    pub(crate) effects: Vec<FoundEffect>,
    /// Share of the gap that they explain.
    pub(crate) explained: Option<ExplainedShare>,
    /// Names of the best set and its rivals.
    pub(crate) set_names: Vec<String>,
    /// Name of the best set, if any is better than none …
    pub(crate) best_name: Option<String>,
    /// … and the objection to it, as a clause.
    pub(crate) objection: String,
    pub(crate) candidates: Vec<Candidate>,
    /// Held-out error shared with the baseline.
    pub(crate) shared: Option<BaselineShare>,
    pub(crate) next_experiments: Vec<NextExperiment>,
    pub(crate) alternatives: Alternatives,
    /// Whether calibration on the baseline changed the model.
    pub(crate) is_calibrated: bool,
}

/// Significance level at which a residual exceeds the noise from all other sources
/// (docs/method/search.md, "Noise").
const ABOVE_NOISE: f64 = 1e-3;
/// Uncertain parameters that are farther off, in standard deviations, stand for something else.
const MAX_DEVIATIONS: f64 = 4.0;

/// The best set with the verdict on it.
struct JudgedSet<'a> {
    decision: Decision,
    /// The objection to it, as a clause.
    objection: String,
    /// Share of the gap that it explains.
    explained: Option<ExplainedShare>,
    rivals: Vec<Vec<Rival<'a>>>,
    /// Held-out trials of the answer: without the set if it is refuted.
    held_out: HeldOutCheck,
}

impl Problem<'_> {
    /// The evidence of a search in the `original` recording.
    pub(crate) fn evidence(
        &self,
        original: &Recording,
        final_fit: &FinalFit,
        outcome: &SearchOutcome,
    ) -> Evidence {
        let (best, fine) = (&outcome.best.fitted, &final_fit.fine);
        let search_problem = &self.fit_problem();
        let fit_problem = &FitProblem {
            nuisances: &fine.nuisances,
            samples: &fine.samples,
            ..search_problem.clone()
        };
        let judged = self.judged_set(fit_problem, final_fit, outcome);
        let JudgedSet { decision, objection, held_out, .. } = &judged;
        let is_named = decision.names_effects();
        let residuals = self.residual_evidence(final_fit, outcome, &judged);
        let noise = &residuals.noise;
        let named = if is_named {
            fit_problem.named_effects(search_problem, outcome, &judged.rivals)
        } else {
            NamedEffects::default()
        };
        let added = if is_named {
            effect_specs(&self.candidates, &outcome.rounded_members())
        } else {
            None
        };
        let model = self.model_with(&added.unwrap_or_default());
        let explained = judged.explained.filter(|_| is_named);
        let null = &outcome.null.fitted;
        // Without a named set the error of the given model is what remains.
        let remaining =
            explained.or_else(|| self.explained_share(search_problem, null, noise.rms_m()));
        let mut limitations = validate::limitations(original, &self.all);
        limitations.extend(self.answer_caveats(final_fit, outcome, &judged));
        limitations.extend(self.resolution_caveat(&model));
        Evidence {
            mistake: None,
            possible_mistake: None,
            baseline_error: self.baseline_error(),
            clock: None,
            gap: Gap {
                metric: metric(&self.all),
                held_out_trials: self.held_out.trials.iter().map(|trial| trial.number).collect(),
                before_m: self.held_out_before_m(),
                after_m: held_out.after_m,
            },
            error_name: self.all.error_name(),
            left_m: remaining.map_or(f64::NAN, |share| share.left_m),
            model_form_m: self.model_form_m,
            limitations,
            search: SearchEvidence {
                effects: named.effects,
                explained,
                set_names: named.sets.iter().map(|set| set_name(&self.candidates, set)).collect(),
                best_name: (!best.members.is_empty())
                    .then(|| set_name(&self.candidates, &best.members)),
                candidates: self.candidate_rows(fit_problem, outcome, decision, objection),
                shared: self.shared_with_baseline(held_out, noise),
                next_experiments: self.rank_protocols(&named.sets, noise),
                alternatives: self.alternatives(null),
                is_calibrated: self.base.as_ref().is_some_and(|base| base.factors.is_some()),
                objection: judged.objection,
            },
            residuals,
            decision: judged.decision,
            model,
        }
    }

    /// The verdict on the best set and what it is decided from.
    fn judged_set<'a>(
        &self,
        fit_problem: &FitProblem,
        final_fit: &FinalFit,
        outcome: &'a SearchOutcome,
    ) -> JudgedSet<'a> {
        let best = &outcome.best.fitted;
        let explained = self.explained_share(fit_problem, best, final_fit.goodness.floor.rms_m());
        let rivals = outcome.rivals(self.options.rival_score);
        let set = SetEvidence {
            effects: best.members.len(),
            failed_test: final_fit.goodness.failed,
            // The judgement by trials has already asked for more than half of the gap.
            explains_gap: outcome.by_trials.is_some()
                || best.members.len() == 1 && self.explains_gap(explained),
            has_rivals: !rivals.iter().all(Vec::is_empty),
            misses_baseline: self.baseline_error().is_some_and(|error| error.is_motion()),
            held_out: HeldOutResult::Supported,
        };
        // Held-out trials stay unseen unless they can still change the verdict.
        let held_out = if set.is_rejected_in_training() {
            self.held_out_unchecked(HeldOutResult::Supported)
        } else {
            self.validate_on_held_out(fit_problem, best, &outcome.rounded_members())
        };
        let decision =
            decide(&VerdictEvidence::BestSet(SetEvidence { held_out: held_out.result, ..set }));
        let objection = decision.objection.map_or_else(String::new, |objection| {
            summary_text::objection(&objection, [self.held_out_before_m(), held_out.after_m])
        });
        // A refuted set changes no error.
        let is_refuted = decision.verdict == Verdict::Unexplained;
        let held_out = if is_refuted { self.held_out_unchecked(held_out.result) } else { held_out };
        JudgedSet { decision, objection, explained, rivals, held_out }
    }

    /// What remains in the residuals of the answer, or of the given model where nothing is named.
    fn residual_evidence(
        &self,
        final_fit: &FinalFit,
        outcome: &SearchOutcome,
        judged: &JudgedSet,
    ) -> ResidualEvidence {
        let (best, null) = (&outcome.best.fitted, &outcome.null.fitted);
        let decision = &judged.decision;
        let before = self.cross_trial_test(&null.nuisance_fit, &self.simulated_m);
        // A set that is not named changes nothing in the residual that the reader sees.
        let (answer, simulated_m, after) = if decision.names_effects() {
            (best, &best.simulated_m, &final_fit.cross_trial)
        } else {
            (null, &self.simulated_m, &before)
        };
        // A residual counts as noise only if nothing is missing in it.
        let explained_all =
            (decision.verdict != Verdict::Unexplained).then_some(&answer.nuisance_fit);
        let (floor, noise) =
            self.combined_floor(&final_fit.goodness.floor, explained_all, &best.nuisance_fit);
        let mut rows = self.residual_rows(simulated_m, &judged.held_out.simulated_m);
        let places = self.residual_map(&rows, &noise);
        // The map needs training rows first; the table is read trial by trial.
        rows.sort_by_key(|row| row.trial);
        let is_complete = decision.is_complete();
        let pattern = if is_complete {
            String::new()
        } else {
            summary_text::pattern(&after.foretold, &places)
        };
        let (missing_before, missing_after) = (before.test.clone(), after.test.clone());
        ResidualEvidence {
            noise,
            noise_from: floor.from.join(", "),
            noise_is_bound: !floor.has_repeats,
            rows,
            places,
            missing_before,
            missing_after,
            pattern,
        }
    }

    /// The model with the effects `added`, at the resolution of the given one.
    fn model_with(&self, added: &[EffectSpec]) -> Model {
        let mut model = self.model.clone();
        // The user's file keeps its own resolution; that of the search is for speed.
        model.robot.resolution = self.given_model.robot.resolution;
        model.effects.extend(added.iter().cloned());
        model
    }

    /// Caveats of the answer.
    fn answer_caveats(
        &self,
        final_fit: &FinalFit,
        outcome: &SearchOutcome,
        judged: &JudgedSet,
    ) -> Vec<String> {
        let (decision, held_out) = (&judged.decision, &judged.held_out);
        let is_named = decision.names_effects();
        let mut sentences = self.caveats(decision.verdict);
        sentences.extend(
            final_fit.goodness.tolerated_m.filter(|_| is_named).map(summary_text::tolerated_caveat),
        );
        if let HeldOutResult::Tolerated(test) = &held_out.result {
            sentences.push(summary_text::held_out_caveat(test));
        }
        if outcome.by_trials.is_some() && is_named {
            sentences.push(summary_text::by_trials_caveat(self.model_form_m));
        }
        sentences.extend(self.strained_caveat(final_fit, held_out));
        sentences.extend(self.unrelaxed_caveat(final_fit).filter(|_| is_named));
        sentences
    }

    /// What the fit assumes of the rest before trials, where an effect takes time to relax.
    fn unrelaxed_caveat(&self, final_fit: &FinalFit) -> Option<String> {
        let FineFit { samples, nuisances, fitted } = &final_fit.fine;
        let members = effect_specs(&self.candidates, &fitted.members)?;
        let mut effects = members.iter().chain(&self.model.effects);
        let time_s = effects.find_map(EffectSpec::relaxation_time_s)?;
        let precision =
            FitProblem { nuisances, samples, ..self.fit_problem() }.nuisance_precision(fitted)?;
        let column = self.uncertain(&fitted.members).unrelaxed_column();
        let deviation = precision.try_inverse()?[(column, column)].sqrt();
        let share = fitted.nuisance_fit.amounts[column];
        Some(summary_text::unrelaxed_caveat(share, deviation, time_s))
    }

    /// Whether one effect that explains this much is named although something remains: where the
    /// model does not describe the robot exactly, and surely more is explained than half of what is
    /// asked for. Several effects together imitate much that is not in the catalogue, so that they
    /// are held to the tests.
    fn explains_gap(&self, explained: Option<ExplainedShare>) -> bool {
        let min_share = self.options.least_explained;
        let is_inexact =
            self.base.as_ref().map_or(self.model_form_m > 0.0, |base| base.form.is_inexact);
        is_inexact
            && explained.is_some_and(|explained| {
                explained.share >= min_share && explained.interval_95[0] >= 0.5 * min_share
            })
    }

    /// Part of the held-out residual shared with the baseline and the rest, if relevant.
    fn shared_with_baseline(
        &self,
        held_out: &HeldOutCheck,
        noise: &Ar1Noise,
    ) -> Option<BaselineShare> {
        let apart_m =
            rms_m(&held_out.residual.as_ref().filter(|_| self.base.is_some())?.residual_m);
        // Both parts are independent, so their squares add up.
        let shared_m = (held_out.after_m.powi(2) - apart_m.powi(2)).max(0.0).sqrt();
        (shared_m > self.least_relevant_m(noise.rms_m()))
            .then_some(BaselineShare { shared_m, apart_m })
    }

    /// Caveat if uncertain parameters, farther off than their uncertainty allows, explain a
    /// relevant part of the held-out residual. With a baseline they were estimated from that.
    fn strained_caveat(&self, final_fit: &FinalFit, held_out: &HeldOutCheck) -> Option<String> {
        let residual = held_out.residual.as_ref().filter(|_| self.base.is_none())?;
        let explained_m =
            (held_out.after_m.powi(2) - rms_m(&residual.residual_m).powi(2)).max(0.0).sqrt();
        let fine = &final_fit.fine;
        let deviations = fine.nuisances.deviations(&fine.fitted.nuisance_fit.amounts);
        let is_strained = deviations > MAX_DEVIATIONS
            && explained_m > self.least_relevant_m(residual.noise.rms_m());
        is_strained.then(|| summary_text::strained_caveat(explained_m, deviations))
    }

    /// Noise from the `floor` and, if nothing is missing beside `explained_all`, from its residual.
    /// `best`: fit of the best set.
    fn combined_floor(
        &self,
        floor: &NoiseFloor,
        explained_all: Option<&NuisanceFit>,
        best: &NuisanceFit,
    ) -> (NoiseFloor, Ar1Noise) {
        let residual = NoiseFloor::of_residual(explained_all.unwrap_or(best), &self.training);
        let floor = floor.clone();
        let combined = match explained_all {
            // A residual that exceeds the noise holds more than noise and must not raise its
            // estimate.
            Some(_) if floor.p_value_of(&residual) < ABOVE_NOISE => floor,
            Some(_) => floor.combined_with(residual),
            // Without repeats the residual of the best set bounds the noise from above.
            None if floor.freedom >= 1.0 && floor.rms_m() > 0.0 => floor,
            None => residual,
        };
        let sigma_m = combined.variance_m2.map(|variance_m2| variance_m2.sqrt().max(MIN_SIGMA_M));
        (combined, Ar1Noise { sigma_m, correlation: best.noise.correlation })
    }

    fn residual_rows(&self, training_m: &[f64], held_out_m: &[f64]) -> Vec<ResidualRow> {
        let points = self.model.tracking.names();
        let rows = |samples: &Samples, before_m: &[f64], after_m: &[f64], is_held_out: bool| {
            let [before_m, after_m] =
                [before_m, after_m].map(|simulated_m| samples.residual(simulated_m));
            residual_map::residual_rows(samples, &points, [&before_m, &after_m], &|_| is_held_out)
        };
        // Held-out rows come last, as in `residual_map`.
        let training = rows(&self.training, &self.simulated_m, training_m, false);
        [training, rows(&self.held_out, &self.held_out_simulated_m, held_out_m, true)].concat()
    }

    /// The residual map of all samples: those of the training, then the held-out ones, as in
    /// `rows`.
    fn residual_map(&self, rows: &[ResidualRow], noise: &Ar1Noise) -> Vec<PlaceRow> {
        let simulated_m = [self.simulated_m.as_slice(), &self.held_out_simulated_m].concat();
        let numbers =
            self.training.trials.iter().chain(&self.held_out.trials).map(|trial| trial.number);
        let index = |number: u64| self.all.trials.iter().position(|trial| trial.number == number);
        let all = self.all.of_trials(&numbers.filter_map(index).collect::<Vec<usize>>());
        let covariates = sample_covariates(&all, &simulated_m);
        residual_map(&covariates, &self.model.tracking.names(), rows, noise)
    }
}

/// Definition of the held-out error of these samples.
pub(crate) fn metric(samples: &Samples) -> String {
    format!("{} on held-out trials", samples.error_name())
}
