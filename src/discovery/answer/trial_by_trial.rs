//! One effect of a robot that the model does not describe exactly, judged trial by trial beside the
//! baseline.
//!
//! What the model itself leaves on such a robot is alike in neighbouring rows and along the body,
//! so that a likelihood takes it for far more evidence than it is. Here a trial is the independent
//! unit: the amplitude of an effect, fitted to each trial by itself, must be larger in the trials
//! of the measured recording than in those of the baseline.

use std::collections::BTreeSet;

use super::final_fit::FinalFit;
use crate::discovery::fit::candidate::{candidate_set, effect_specs};
use crate::discovery::fit::gauss_newton::FitProblem;
use crate::discovery::fit::jackknife;
use crate::discovery::fit::simulate;
use crate::discovery::problem::{Baseline, Problem};
use crate::discovery::recording::samples::Samples;
use crate::discovery::search::{ScoredSet, Search, TrialEvidence};
use crate::math::distribution::{student_95, student_beyond};
use crate::math::summary::{mean, standard_deviation};

/// Number of sets with the largest scores that are judged. This and the constants below were chosen
/// on one trunk (docs/method/search.md, "Robots whose physics is not exactly the model's").
const MAX_JUDGED: usize = 6;
/// Fewest trials on either side.
const MIN_TRIALS: usize = 3;
/// Share of the held-out gap that the effect must explain, its interval above zero.
const MIN_EXPLAINED_SHARE: f64 = 0.5;
/// A set is an equal of the best unless the chance of errors on unseen trials that are so much
/// larger is below this.
const WORSE_P_VALUE: f64 = 0.05;

/// Effects, and those of which they are special cases: a weight is a force along gravity.
const SPECIAL_CASES: [(&str, &str); 2] =
    [("tip_load", "tip_force"), ("bending_stiffness", "anisotropic_stiffness")];

/// The effect that was judged best, with the evidence of the trials.
pub(crate) struct JudgedEffect {
    pub(crate) best: ScoredSet,
    pub(crate) final_fit: FinalFit,
    pub(crate) evidence: TrialEvidence,
}

/// A set beside the trials.
struct Judged {
    scored: ScoredSet,
    /// Whether it is larger in the measured trials than in those of the baseline.
    is_larger: bool,
    /// Its amplitude in each measured trial.
    amplitudes: Vec<f64>,
    /// Mean square on each of them of a fit to the others, square metres.
    unseen_m2: Vec<f64>,
}

impl Problem<'_> {
    /// The single effect that fits unseen trials best among those that are larger than in the
    /// baseline. None without a baseline, and where the model describes the robot exactly.
    pub(crate) fn judge_by_trials(&self, search: &Search) -> Option<JudgedEffect> {
        // Only a model-form error breaks the likelihood; else the scores decide.
        let base = self.base.as_ref().filter(|_| self.model_form_m > 0.0)?;
        let fit_problem = self.fit_problem();
        // 1. The amplitude of each leading effect in every trial, beside the baseline's.
        let residual_m =
            self.nuisances.residual_by_prior(&self.training.residual(&self.simulated_m));
        let judged: Vec<Judged> = leading_singles(search)
            .into_iter()
            .filter_map(|scored| {
                let (amplitudes, is_larger) = self.amplitudes_beside(base, &scored, &residual_m)?;
                let errors_m = jackknife::left_out_errors_m(&fit_problem, &scored.fitted);
                let unseen_m2 = errors_m.iter().map(|error_m| error_m * error_m).collect();
                Some(Judged { scored, is_larger, amplitudes, unseen_m2 })
            })
            .collect();
        // 2. Of the effects that are larger, the one that predicts unseen trials best, or a special
        //    case of it.
        let larger = judged.iter().filter(|judged| judged.is_larger);
        let top = larger.min_by(|a, b| mean(&a.unseen_m2).total_cmp(&mean(&b.unseen_m2)))?;
        // More numbers of the same kind that gain less than the model leaves anyway fit what it
        // leaves.
        let within = |judged: &&Judged| {
            mean(&judged.unseen_m2) < mean(&top.unseen_m2) + self.model_form_m.powi(2)
        };
        let is_case_of_top = |judged: &&Judged| self.is_case_of(judged, top);
        let best = judged.iter().filter(within).find(is_case_of_top).unwrap_or(top);
        let set = |judged: &Judged| candidate_set(&judged.scored.fitted.members);
        // Nor do scores count for nothing: they hold what sizes are plausible.
        let rival_score = self.options.rival_score;
        let is_equal = |other: &&Judged| {
            set(other) != set(best)
                && !self.is_case_of(best, other)
                && other.scored.is_rival_of(&best.scored, rival_score)
                && !is_worse(other, best)
        };
        // 3. Sets that predict unseen trials as well are its rivals.
        let evidence = TrialEvidence {
            equals: judged.iter().filter(is_equal).map(set).collect(),
            half_width: half_width(&best.amplitudes),
        };
        // 4. It must explain most of the held-out gap.
        let final_fit = self.final_fit(&best.scored.fitted);
        let fine = &final_fit.fine;
        let fit_problem =
            &FitProblem { nuisances: &fine.nuisances, samples: &fine.samples, ..fit_problem };
        let explained =
            self.explained_share(fit_problem, &fine.fitted, final_fit.goodness.floor.rms_m())?;
        let explains_most = explained.share > MIN_EXPLAINED_SHARE && explained.interval_95[0] > 0.0;
        explains_most.then_some(JudgedEffect { best: best.scored.clone(), final_fit, evidence })
    }

    /// Whether an effect is a special case of another.
    fn is_case_of(&self, special: &Judged, general: &Judged) -> bool {
        let name =
            |judged: &Judged| self.candidates[judged.scored.fitted.members[0].candidate].card.name;
        SPECIAL_CASES.contains(&(name(special), name(general)))
    }

    /// Amplitudes of a set in the measured trials, and whether they are larger than in those of the
    /// baseline (t-test of Welch, Biometrika 34, 1947). `residual_m`: what the uncertain parameters
    /// leave of the training trials.
    fn amplitudes_beside(
        &self,
        base: &Baseline,
        scored: &ScoredSet,
        residual_m: &[f64],
    ) -> Option<(Vec<f64>, bool)> {
        let effects = effect_specs(&self.candidates, &scored.fitted.members)?;
        let simulated_m = simulate::tips(&self.model, &effects, &base.samples)?;
        let moved_m: Vec<f64> = simulated_m
            .iter()
            .zip(&base.simulated_m)
            .map(|(with, without)| with - without)
            .collect();
        // As many corrections are taken off both sides, so that amplitudes compare.
        let before = amplitudes(&base.samples, &base.form.unseen_m, &moved_m);
        // Each recording has its own commands, hence its own displacement.
        let moved_m = self.displacement_m(&scored.fitted.simulated_m);
        let after = amplitudes(&self.training, residual_m, &moved_m);
        let has_trials = before.len().min(after.len()) >= MIN_TRIALS;
        let is_larger = has_trials && chance_of_more(&before, &after) < self.options.false_alarm;
        Some((after, is_larger))
    }
}

/// The single effects with the largest scores, fully fitted.
fn leading_singles(search: &Search) -> Vec<ScoredSet> {
    let mut singles: Vec<&ScoredSet> =
        search.tried.iter().filter(|scored| scored.fitted.members.len() == 1).collect();
    singles.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut listed = BTreeSet::new();
    singles.retain(|scored| listed.insert(candidate_set(&scored.fitted.members)));
    singles
        .into_iter()
        .take(MAX_JUDGED)
        .map(|scored| if scored.exact { scored.clone() } else { search.fit_fully(scored) })
        .collect()
}

/// The amplitude of a displacement `moved_m` in the residual of each trial, by least squares.
fn amplitudes(samples: &Samples, residual_m: &[f64], moved_m: &[f64]) -> Vec<f64> {
    let of = |rows: std::ops::Range<usize>| {
        let values = 3 * rows.start..3 * rows.end;
        let (residual_m, moved_m) = (&residual_m[values.clone()], &moved_m[values]);
        let along: f64 =
            residual_m.iter().zip(moved_m).map(|(residual, moved)| residual * moved).sum();
        along / moved_m.iter().map(|moved| moved * moved).sum::<f64>().max(f64::MIN_POSITIVE)
    };
    samples.ranges().into_iter().filter(|rows| !rows.is_empty()).map(of).collect()
}

/// Probability that numbers with the same mean differ by this much or more, `after` being larger.
fn chance_of_more(before: &[f64], after: &[f64]) -> f64 {
    let [a, b] = [before, after].map(|side| standard_deviation(side).powi(2) / side.len() as f64);
    // Degrees of freedom of Welch and Satterthwaite for unequal variances.
    let freedom = (a + b).powi(2)
        / (a * a / (before.len() as f64 - 1.0) + b * b / (after.len() as f64 - 1.0));
    let t = (mean(after) - mean(before)) / (a + b).sqrt();
    // One-sided: an effect that is smaller than before is not the change.
    if t > 0.0 { 0.5 * student_beyond(t, freedom) } else { 1.0 }
}

/// Half of the 95 % interval of the mean, over the mean.
fn half_width(amplitudes: &[f64]) -> f64 {
    let trials = amplitudes.len() as f64;
    student_95(trials - 1.0) * standard_deviation(amplitudes)
        / trials.sqrt()
        / mean(amplitudes).abs()
}

/// Whether `other` fits unseen trials significantly worse than `top` (paired t-test over the
/// trials).
fn is_worse(other: &Judged, top: &Judged) -> bool {
    let more: Vec<f64> =
        other.unseen_m2.iter().zip(&top.unseen_m2).map(|(other, top)| other - top).collect();
    // Pairing takes off what makes one trial harder than another for every set.
    let spread = standard_deviation(&more) / (more.len() as f64).sqrt();
    let t = mean(&more) / spread.max(f64::MIN_POSITIVE);
    t > 0.0 && 0.5 * student_beyond(t, more.len() as f64 - 1.0) < WORSE_P_VALUE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discovery::recording::samples::white_noise;

    #[test]
    fn the_amplitude_of_each_trial_is_found_beside_what_stands_across() {
        let samples = Samples::alike(3, 10);
        let moved_m: Vec<f64> = (0..90).map(|k| if k % 3 == 0 { 1e-3 } else { 0.0 }).collect();
        let residual_m: Vec<f64> =
            (0..90).map(|k| if k % 3 == 0 { 1e-3 * (k / 30) as f64 } else { 5e-3 }).collect();
        for (found, expected) in
            amplitudes(&samples, &residual_m, &moved_m).iter().zip([0.0, 1.0, 2.0])
        {
            assert!((found - expected).abs() < 1e-12, "{found} of {expected}");
        }
    }

    #[test]
    fn amplitudes_that_are_larger_are_told_from_those_that_scatter_as_much() {
        let drawn = |offset: f64, seed: u64| {
            let mut noise = white_noise(0.3, seed);
            let before: Vec<f64> = (0..8).map(|_| noise()).collect();
            chance_of_more(&before, &(0..6).map(|_| offset + noise()).collect::<Vec<f64>>())
        };
        let low = (0..1000).filter(|&seed| drawn(0.0, seed) < 0.05).count();
        assert!((25..80).contains(&low), "{low} of 1000 below 0.05");
        let found = (0..100).filter(|&seed| drawn(1.0, seed) < 1e-3).count();
        assert!(found > 80, "{found} of 100");
        assert_eq!(chance_of_more(&[1.0, 1.1, 0.9], &[0.0, 0.1, -0.1]), 1.0, "smaller is not more");
    }
}
