//! Assembles the result of a discovery: decision, held-out test, residual map, next experiments.

use super::Discovery;
use super::alternatives::Alternatives;
use super::explained_share::ExplainedShare;
use super::final_fit::{FinalFit, FineFit};
use super::residual_rows::residual_rows;
use super::verdict::{Decision, set_name};
use super::{alternatives, residual_map, summary_text};
use crate::data::Recording;
use crate::data::findings::{self, Candidate, Findings, Gap, PlaceRow, ResidualRow, Verdict};
use crate::discovery::fit::ar1_noise::{Ar1Noise, LEAST_SIGMA_M};
use crate::discovery::fit::candidate::effect_specs;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::nuisance::NuisanceFit;
use crate::discovery::fit::{jackknife, simulate};
use crate::discovery::goodness_of_fit::test_result::TestResult;
use crate::discovery::noise_floor::NoiseFloor;
use crate::discovery::problem;
use crate::discovery::problem::Problem;
use crate::discovery::recording::covariates::sample_covariates;
use crate::discovery::recording::samples::rms_m;
use crate::discovery::recording::validate;
use crate::discovery::search::{ScoredSet, SearchOutcome};
use crate::effects::{EffectSpec, Model};

/// Significance level at which a residual exceeds the noise from all other sources.
const MORE_THAN_NOISE: f64 = 1e-3;

/// Uncertain parameters that are farther off, in standard deviations, stand for something else.
const MOST_DEVIATIONS: f64 = 4.0;

/// A decision with its held-out test.
struct CheckedDecision {
    answer: Decision,
    /// Effects that are added to the model.
    added: Vec<EffectSpec>,
    gap: Gap,
    /// Simulated tip on held-out trials.
    simulated_m: Vec<f64>,
    /// Residual on held-out trials.
    unseen: HeldOutResidual,
}

/// Held-out residual of an answer that passed.
#[derive(Default)]
struct HeldOutResidual {
    /// Without uncertain parameters and errors shared with the baseline.
    left: Option<NuisanceFit>,
    /// Failed variance test that other values within the intervals would pass.
    tolerated_on_held_out: Option<TestResult>,
    /// Failed variance test of an answer that explains most of the gap, but not all of it.
    more: Option<TestResult>,
}

impl CheckedDecision {
    /// What remains beside named effects, as a clause; none if the answer is complete.
    fn remaining(&self) -> Option<String> {
        let named = !self.answer.members.is_empty();
        let of_training = (!self.answer.objection.is_empty()).then(|| self.answer.objection.clone());
        let of_held_out = self.unseen.more.as_ref().map(summary_text::objection);
        of_training.or(of_held_out).filter(|_| named)
    }
}

impl Problem<'_> {
    /// Assembles the result of a search.
    pub(crate) fn discovery(
        &self,
        given: &Model,
        measured: &Recording,
        final_fit: &FinalFit,
        found: &SearchOutcome,
    ) -> Discovery {
        let best = &found.best.fitted;
        let fit_problem = &FitProblem {
            nuisances: &final_fit.fine.nuisances,
            samples: &final_fit.fine.samples,
            ..self.fit_problem()
        };
        let before = self.cross_trial_test(&found.null.fitted.nuisance_fit, &self.simulated_m);
        let after = &final_fit.cross_trial;
        let (checked, explained) = self.decide_and_check(fit_problem, final_fit, found);
        let answer = &checked.answer;
        let named = !answer.members.is_empty();
        let (told, simulated_m, missing) = if named {
            (&best.nuisance_fit, &best.simulated_m, after)
        } else {
            (&found.null.fitted.nuisance_fit, &self.simulated_m, &before)
        };
        let unexplained = answer.verdict == Verdict::Unexplained;
        let (from, noise) =
            self.combined_floor(&final_fit.goodness.floor, (!unexplained).then_some(told), &best.nuisance_fit);
        let mut residuals = self.residual_rows(simulated_m, &checked.simulated_m);
        let places = self.build_map(&residuals, &noise);
        let next = self.rank_protocols(&answer.rivals, &noise);
        let model = self.model_with(&checked.added, given);
        let share = explained.filter(|_| named);
        let complete = !unexplained && checked.remaining().is_none();
        let mut findings = Findings {
            verdict: answer.verdict,
            effects: answer.effects.clone(),
            noise_floor_m: noise.rms_m(),
            explained_share: share.map(|explained| explained.share),
            explained_share_interval_95: share.map(|explained| explained.interval_95),
            left_m: share.or_else(|| self.unexplained_share(found, noise.rms_m())).map_or(f64::NAN, |own| own.left_m),
            complete,
            model_form_m: self.model_form_m,
            gap: checked.gap.clone(),
            disagreement: residual_map::disagreements(&places),
            candidates: self.candidate_rows(fit_problem, found, answer),
            next_measurement: String::new(),
            summary: String::new(),
            noise: findings::Noise { sigma_m: noise.sigma_m, correlation: noise.correlation, from },
            missing_before: before.test.clone(),
            missing_after: missing.test.clone(),
            pattern: if complete { String::new() } else { summary_text::pattern(&missing.foretold, &places) },
            limitations: self.limitations(measured, (final_fit, found), &checked, &model),
            excluded_rows: Vec::new(),
            clock_offset_s: None,
            clock_offset_interval_95: None,
            proposals: next.iter().map(|next| next.proposal.clone()).collect(),
        };
        self.write_texts(&mut findings, best, &checked, &noise);
        residuals.sort_by_key(|row| row.trial);
        Discovery {
            findings,
            model,
            residuals,
            places,
            alternatives: self.alternatives(&found.null.fitted),
            next_experiments: next,
            calibrated: self.is_calibrated(),
        }
    }

    /// The decision with its check on held-out trials, and the share of the gap that the best set explains.
    fn decide_and_check(
        &self,
        fit_problem: &FitProblem,
        final_fit: &FinalFit,
        found: &SearchOutcome,
    ) -> (CheckedDecision, Option<ExplainedShare>) {
        let best = &found.best.fitted;
        let explained = self.explained_share(fit_problem, best, final_fit.goodness.floor.rms_m());
        let most = found.by_trials.is_some() || best.members.len() == 1 && self.explains_most(explained);
        let sign = (final_fit.goodness.failed, most);
        let decided = fit_problem.decide(&self.fit_problem(), found, sign, self.options.rival_score);
        (self.check_on_held_out(fit_problem, best, decided, most), explained)
    }

    /// What is left where nothing is named.
    fn unexplained_share(&self, found: &SearchOutcome, floor_m: f64) -> Option<ExplainedShare> {
        self.explained_share(&self.fit_problem(), &found.null.fitted, floor_m)
    }

    /// The model with the effects `added`, at the resolution of the `given` one.
    fn model_with(&self, added: &[EffectSpec], given: &Model) -> Model {
        let mut model = self.model.clone();
        model.robot.resolution = given.robot.resolution;
        model.effects.extend(added.iter().cloned());
        model
    }

    /// Limitations of the data and caveats of the answer.
    fn limitations(
        &self,
        measured: &Recording,
        (final_fit, found): (&FinalFit, &SearchOutcome),
        checked: &CheckedDecision,
        model: &Model,
    ) -> Vec<String> {
        let named = !checked.answer.members.is_empty();
        let tolerated = final_fit.goodness.tolerated_m.filter(|_| named).map(summary_text::tolerated_caveat);
        let tolerated_on_held_out = checked.unseen.tolerated_on_held_out.as_ref().map(summary_text::held_out_caveat);
        let caveats = self.caveats(checked.answer.verdict).into_iter().chain(tolerated).chain(tolerated_on_held_out);
        let by_trials = found.by_trials.is_some() && named;
        let by_trials = by_trials.then(|| summary_text::by_trials_caveat(self.model_form_m));
        let strained = self.strained_caveat(&final_fit.fine, checked);
        let caveats = caveats.chain(by_trials).chain(strained).chain(self.cannot_follow(model));
        validate::limitations(measured, &self.all).into_iter().chain(caveats).collect()
    }

    /// Writes the summary and the next measurement into the findings.
    fn write_texts(&self, findings: &mut Findings, best: &FittedSet, checked: &CheckedDecision, noise: &Ar1Noise) {
        let answer = &checked.answer;
        let sets: Vec<String> = answer.rivals.iter().map(|set| set_name(&self.candidates, set)).collect();
        let refused = (!best.members.is_empty()).then(|| set_name(&self.candidates, &best.members));
        let beside = summary_text::SummaryContext {
            sets: &sets,
            refused,
            objection: &answer.objection,
            remains: checked.remaining(),
            error: self.all.error_name(),
            shared: self.shared(checked, noise),
        };
        findings.summary = summary_text::summary(findings, &beside);
        findings.next_measurement = summary_text::next_measurement(findings);
    }

    /// Held-out errors of the alternatives to naming the effect.
    fn alternatives(&self, null: &FittedSet) -> Alternatives {
        alternatives::fit_alternatives(
            &self.fit_problem(),
            &self.sensitivities,
            null,
            &self.held_out,
            &self.held_out_simulated_m,
        )
    }

    /// Whether one effect that explains this much is named although something remains: where the model does not describe
    /// the robot exactly, and surely more is explained than half of what is asked for. Several effects together imitate
    /// much that is not in the catalogue, so that they are held to the tests.
    fn explains_most(&self, explained: Option<ExplainedShare>) -> bool {
        let least = self.options.least_explained;
        let enough = |explained: ExplainedShare| explained.share >= least && explained.interval_95[0] >= 0.5 * least;
        let inexact = self.base.as_ref().map_or(self.model_form_m > 0.0, |base| base.form.is_inexact);
        inexact && explained.is_some_and(enough)
    }

    /// Limitation if `model` cannot be simulated at its own resolution.
    fn cannot_follow(&self, model: &Model) -> Option<String> {
        problem::simulate_model(model, &self.all).err().map(|_| {
            "`model.yaml` cannot be simulated with these commands at its own resolution, which differs from that \
         of the fit: use a coarser `robot.resolution` in `simulate`."
                .to_owned()
        })
    }

    /// Tests the answer on held-out trials. It is refuted if it increases the error there or if held-out trials
    /// scatter significantly more than the training trials.
    fn check_on_held_out(
        &self,
        fit_problem: &FitProblem,
        best: &FittedSet,
        answer: Decision,
        most: bool,
    ) -> CheckedDecision {
        let added = effect_specs(&self.candidates, &answer.members).unwrap_or_default();
        let mut gap = Gap {
            metric: format!("{} on held-out trials", self.all.error_name()),
            held_out_trials: self.held_out.trials.iter().map(|trial| trial.number).collect(),
            before_m: rms_m(&self.held_out.residual(&self.held_out_simulated_m)),
            after_m: f64::NAN,
        };
        // At the limits of what can be simulated the resolution decides.
        let tips = |model: &Model| simulate::tips(model, &added, &self.held_out);
        let simulated_m = tips(&self.model).or_else(|| tips(&self.coarse));
        let cannot_follow = || "the model with it cannot be simulated on the held-out trials".to_owned();
        let bear_out_or_refute = simulated_m.ok_or_else(cannot_follow).and_then(|simulated_m| {
            gap.after_m = rms_m(&self.held_out.residual(&simulated_m));
            self.bear_out_or_refute(fit_problem, best, &answer, (&simulated_m, &gap), most)
                .map(|unseen| (simulated_m, unseen))
        });
        match bear_out_or_refute {
            Ok((simulated_m, unseen)) => CheckedDecision { answer, added, gap, simulated_m, unseen },
            Err(objection) => {
                gap.after_m = gap.before_m;
                let answer = Decision::refuted(objection);
                CheckedDecision {
                    answer,
                    added: Vec::new(),
                    gap,
                    simulated_m: self.held_out_simulated_m.clone(),
                    unseen: HeldOutResidual::default(),
                }
            }
        }
    }

    /// Residual on held-out trials if they support the answer, else the objection.
    fn bear_out_or_refute(
        &self,
        fit_problem: &FitProblem,
        best: &FittedSet,
        answer: &Decision,
        (simulated_m, gap): (&[f64], &Gap),
        most: bool,
    ) -> Result<HeldOutResidual, String> {
        let no_worse = gap.after_m <= gap.before_m;
        if !no_worse {
            return Err(summary_text::worse_on_held_out(gap));
        }
        if answer.verdict == Verdict::Unexplained {
            return Ok(HeldOutResidual::default());
        }
        let left = self.explain_held_out(fit_problem, best, simulated_m);
        let sign = |left: &NuisanceFit| self.held_out_test(best, left);
        let Some(refuted) = left.as_ref().and_then(sign) else {
            return Ok(HeldOutResidual { left, ..HeldOutResidual::default() });
        };
        // If a tendon is always slack its zero is undetermined, and another value may pass.
        if fit_problem.equally_good_fits(best).iter().any(|other| self.is_borne_out_by_held_out(fit_problem, other)) {
            return Ok(HeldOutResidual { left, tolerated_on_held_out: Some(refuted), more: None });
        }
        if most && !answer.members.is_empty() {
            return Ok(HeldOutResidual { left, tolerated_on_held_out: None, more: Some(refuted) });
        }
        Err(summary_text::objection(&refuted))
    }

    /// Part of the held-out residual shared with the baseline and the rest, if relevant.
    fn shared(&self, checked: &CheckedDecision, noise: &Ar1Noise) -> Option<summary_text::BaselineShare> {
        let apart_m = rms_m(&checked.unseen.left.as_ref().filter(|_| self.has_baseline())?.residual_m);
        let shared_m = (checked.gap.after_m.powi(2) - apart_m.powi(2)).max(0.0).sqrt();
        (shared_m > self.least_relevant_m(noise.rms_m())).then_some(summary_text::BaselineShare { shared_m, apart_m })
    }

    /// Caveat if uncertain parameters, farther off than their uncertainty allows, explain a relevant part of the held-out
    /// residual. With a baseline they were estimated from that.
    fn strained_caveat(&self, fine: &FineFit, checked: &CheckedDecision) -> Option<String> {
        let left = checked.unseen.left.as_ref().filter(|_| !self.has_baseline())?;
        let explained_m = (checked.gap.after_m.powi(2) - rms_m(&left.residual_m).powi(2)).max(0.0).sqrt();
        let deviations = fine.nuisances.deviations(&fine.fitted.nuisance_fit.amounts);
        let strained = deviations > MOST_DEVIATIONS && explained_m > self.least_relevant_m(left.noise.rms_m());
        strained.then(|| summary_text::strained_caveat(explained_m, deviations))
    }

    /// Noise from the floor and, if all is `nuisance_fit`, from the residual; with its sources as text. `best`: fit of
    /// the best set.
    fn combined_floor(
        &self,
        tells: &NoiseFloor,
        nuisance_fit: Option<&NuisanceFit>,
        best: &NuisanceFit,
    ) -> (String, Ar1Noise) {
        let left = NoiseFloor::of_residual(nuisance_fit.unwrap_or(best), &self.training);
        let tells = tells.clone();
        let floor = match nuisance_fit {
            Some(_) if tells.p_value_of(&left) < MORE_THAN_NOISE => tells,
            Some(_) => tells.combined_with(left),
            None if tells.freedom >= 1.0 && tells.rms_m() > 0.0 => tells,
            None => left,
        };
        let sigma_m = floor.variance_m2.map(|variance_m2| variance_m2.sqrt().max(LEAST_SIGMA_M));
        (floor.from.join(", "), Ar1Noise { sigma_m, correlation: best.noise.correlation })
    }

    fn residual_rows(&self, after: &[f64], after_proof: &[f64]) -> Vec<ResidualRow> {
        let names = self.model.tracking.names();
        let parts = [
            (&self.training, &self.simulated_m, after, false),
            (&self.held_out, &self.held_out_simulated_m, after_proof, true),
        ];
        let rows = parts.map(|(samples, before, after, held_out)| {
            let [before, after] = [samples.residual(before), samples.residual(after)];
            residual_rows(samples, &names, [&before, &after], &|_| held_out)
        });
        rows.concat()
    }

    fn build_map(&self, rows: &[ResidualRow], noise: &Ar1Noise) -> Vec<PlaceRow> {
        let mut simulated_m = self.simulated_m.clone();
        simulated_m.extend_from_slice(&self.held_out_simulated_m);
        let order: Vec<u64> =
            self.training.trials.iter().chain(&self.held_out.trials).map(|trial| trial.number).collect();
        let place = |number: &u64| self.all.trials.iter().position(|trial| trial.number == *number);
        let all = self.all.of_trials(&order.iter().filter_map(place).collect::<Vec<usize>>());
        let covariates = sample_covariates(&all, &simulated_m);
        let before: Vec<f64> = rows.iter().flat_map(|row| [row.before_x_m, row.before_y_m, row.before_z_m]).collect();
        let after: Vec<f64> = rows.iter().flat_map(|row| [row.after_x_m, row.after_y_m, row.after_z_m]).collect();
        residual_map::residual_map((&covariates, &self.model.tracking.names()), &before, &after, noise)
    }

    fn candidate_rows(&self, fit_problem: &FitProblem, found: &SearchOutcome, answer: &Decision) -> Vec<Candidate> {
        let plain = self.fit_problem();
        let unseen = |scored: &ScoredSet| {
            let own = scored.fitted.members == found.best.fitted.members;
            let each = jackknife::left_out_errors_m(if own { fit_problem } else { &plain }, &scored.fitted);
            crate::math::summary::root_mean_square(&each)
        };
        fit_problem.candidate_rows(found, answer, self.options.rival_score, &unseen)
    }
}
