//! Large-amplitude sensitivities: the response of the tip to a large amount of an effect, or to one
//! of the other sign, can differ from the linear one (a softer rod sags until tendons are taut; a
//! stiffer one does not).
//!
//! The trials with the largest residual decide which of these sensitivities matter; only these are
//! simulated on all trials.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;

use crate::base::counted;

use super::screening::{LinearScreen, ScreenedResidual, VALID_STEPS, best_of_each};
use crate::discovery::fit::candidate::{CandidateEffect, SetMember, effect_specs};
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::sensitivities::{Sensitivity, sensitivities};
use crate::discovery::fit::simulate::tips;
use crate::discovery::recording::samples::{Samples, rms_m};

/// Maximum amplitude in usual sizes.
const MAX_AMPLITUDE: f64 = 8.0;
/// Maximum number of simulations to find the amplitude that moves the tip as far as the residual.
const MAX_SIMULATIONS: usize = 5;
/// Accepted ratio of the tip displacement to the residual.
const ACCEPTED_RATIO: Range<f64> = 0.5..2.0;
/// Refinements near the predicted optimum, and their tolerance.
const MAX_REFINEMENTS: usize = 3;
const STEP_TOLERANCE: f64 = 0.2;
/// Bisections of a scan about its best step.
const SCAN_BISECTIONS: usize = 2;
/// Number of trials used first.
const FIRST_TRIALS: usize = 2;
/// A sensitivity is kept if it predicts this share of the best gain, or a gain this close to it.
const MIN_GAIN_SHARE: f64 = 0.2;
const MAX_GAIN_DEFICIT: f64 = 10.0;

impl FitProblem<'_> {
    /// Sensitivities to each candidate relative to `base`, in both directions, at the amplitude
    /// that would move the tip as far as the residual of `base`, refined towards the best fit. For
    /// each candidate the variant with the best prediction is used. Candidates that are scanned are
    /// evaluated over their whole range.
    pub(crate) fn large_amplitude_sensitivities(
        &self,
        base: &FittedSet,
        sensitivities: &[Sensitivity],
    ) -> Vec<Sensitivity> {
        let all = LargeAmplitudeScreen::new(
            self,
            base,
            &(0..self.samples.trials.len()).collect::<Vec<usize>>(),
        );
        let some = LargeAmplitudeScreen::new(self, base, &self.largest_residual_trials(base));
        let (Some(some_base_m), Some(all_base_m)) = (some.simulate(&[]), all.simulate(&[])) else {
            return Vec::new();
        };
        // 1. Small steps beside the base, in the two trials with the largest residual.
        let beside_base = some.sensitivities_beside_base(&|_| true);
        let (screened, predictions) = if beside_base.is_empty() {
            (
                sensitivities.iter().map(|sensitivity| some.restricted(sensitivity)).collect(),
                self.predictions(base, &[], sensitivities),
            )
        } else {
            let predictions = best_of_each(some.screen.predictions(&beside_base));
            (beside_base, predictions)
        };
        let small_step =
            |of: &Sensitivity| screened.iter().find(|sensitivity| sensitivity.is_small_step_of(of));
        // 2. For each candidate its best small-step variant is where a larger one starts.
        let predicted = predictions
            .iter()
            .filter_map(|prediction| small_step(&screened[prediction.sensitivity]));
        let mut is_listed = vec![false; self.candidates.len()];
        base.members.iter().for_each(|member| is_listed[member.candidate] = true);
        let starts: Vec<&Sensitivity> = predicted
            .chain(screened.iter().filter_map(small_step))
            .filter(|sensitivity| self.open[sensitivity.candidate])
            .filter(|sensitivity| !std::mem::replace(&mut is_listed[sensitivity.candidate], true))
            .collect();
        // 3. Play large amounts of each in these trials.
        let responses: Vec<Sensitivity> = starts
            .into_par_iter()
            .flat_map(counted(|sensitivity| some.sensitivities_of(sensitivity, &some_base_m)))
            .collect();
        // 4. Only what promises enough there is played in all trials.
        let relevant = some.keep_relevant(responses, &screened);
        // The update corrects the sensitivity in one direction only; the other columns hold
        // relative to the base.
        let has_several_sizes = |candidate: &CandidateEffect| {
            let of = |response: &Sensitivity| {
                std::ptr::eq(candidate, &self.candidates[response.candidate])
            };
            candidate.sizes().len() > 1 && relevant.iter().any(of)
        };
        let beside_base = all.sensitivities_beside_base(&has_several_sizes);
        let everywhere = |response: &Sensitivity| {
            let small_step = beside_base
                .iter()
                .chain(sensitivities)
                .find(|sensitivity| sensitivity.is_small_step_of(response))?;
            Some(all.sensitivity_at(small_step, &all_base_m, response.step.as_ref()?)?.0)
        };
        relevant.par_iter().filter_map(counted(everywhere)).collect()
    }

    /// The trials with the largest residual.
    fn largest_residual_trials(&self, base: &FittedSet) -> Vec<usize> {
        let ranges = self.samples.ranges();
        let residual = |trial: usize| -> f64 {
            base.nuisance_fit.residual_m[3 * ranges[trial].start..3 * ranges[trial].end]
                .iter()
                .map(|residual_m| residual_m * residual_m)
                .sum()
        };
        let mut trials: Vec<usize> = (0..ranges.len()).collect();
        trials.sort_by(|&a, &b| residual(b).total_cmp(&residual(a)));
        trials.truncate(FIRST_TRIALS);
        trials
    }
}

/// One step of a scan with its remaining sum of squares.
struct ScanPoint {
    step: f64,
    square: f64,
    response: Sensitivity,
}

/// Large-amplitude screening on some of the trials.
struct LargeAmplitudeScreen<'a> {
    fit_problem: &'a FitProblem<'a>,
    /// The set that is extended.
    base: &'a FittedSet,
    samples: Samples,
    /// Row indices in all samples, three a sample.
    rows: Vec<usize>,
    /// Residual in them, metres.
    residual_m: Vec<f64>,
    screen: LinearScreen<'a>,
}

impl<'a> LargeAmplitudeScreen<'a> {
    fn new(
        fit_problem: &'a FitProblem<'a>,
        base: &'a FittedSet,
        trials: &[usize],
    ) -> LargeAmplitudeScreen<'a> {
        let ranges = fit_problem.samples.ranges();
        let rows: Vec<usize> = trials
            .iter()
            .flat_map(|&trial| 3 * ranges[trial].start..3 * ranges[trial].end)
            .collect();
        let samples = fit_problem.samples.of_trials(trials);
        let residual_m: Vec<f64> =
            rows.iter().map(|&row| base.nuisance_fit.residual_m[row]).collect();
        let nuisances = fit_problem.nuisances.in_rows(&rows);
        let fitted_columns = base.jacobian.select_rows(&rows);
        let screen = LinearScreen::new(
            fit_problem.candidates,
            &samples,
            &nuisances,
            ScreenedResidual { noise: &base.nuisance_fit.noise, residual_m: &residual_m },
            &fitted_columns,
        );
        LargeAmplitudeScreen { fit_problem, base, samples, rows, residual_m, screen }
    }

    /// A sensitivity restricted to these samples.
    fn restricted(&self, sensitivity: &Sensitivity) -> Sensitivity {
        Sensitivity { columns: sensitivity.columns.select_rows(&self.rows), ..sensitivity.clone() }
    }

    /// Sensitivities relative to the members of the base: they can change which tendons are taut.
    fn sensitivities_beside_base(
        &self,
        is_asked: &(dyn Fn(&CandidateEffect) -> bool + Sync),
    ) -> Vec<Sensitivity> {
        let (fit_problem, members) = (self.fit_problem, &self.base.members);
        let is_asked = |candidate: &CandidateEffect| !members.is_empty() && is_asked(candidate);
        sensitivities(fit_problem.coarse, fit_problem.candidates, members, &is_asked, &self.samples)
    }

    /// Simulated tip of the coarse model with the members of the base and `more`.
    fn simulate(&self, more: &[crate::effects::EffectSpec]) -> Option<Vec<f64>> {
        let members = effect_specs(self.fit_problem.candidates, &self.base.members)?;
        tips(self.fit_problem.coarse, &[&members, more].concat(), &self.samples)
    }

    /// `sensitivity` corrected at `step` (Broyden's update, in probes), and the tip displacement;
    /// none if it cannot be simulated.
    fn sensitivity_at(
        &self,
        sensitivity: &Sensitivity,
        base_m: &[f64],
        step: &[f64],
    ) -> Option<(Sensitivity, f64)> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        let sizes = candidate.sizes();
        let effect = candidate.effect(&candidate.with_sizes(&sensitivity.null, step))?;
        let change: Vec<f64> = self
            .simulate(&[effect])?
            .iter()
            .zip(base_m)
            .map(|(step_m, base_m)| step_m - base_m)
            .collect();
        // Broyden's update in probes, so that sizes of different units count alike.
        let step_vector = DVector::from_column_slice(step);
        let along = DVector::from_iterator(
            step.len(),
            sizes.iter().zip(step).map(|(&size, step)| step / candidate.probe(size).powi(2)),
        );
        let missed = DVector::from_column_slice(&change) - &sensitivity.columns * &step_vector;
        let columns = &sensitivity.columns + missed * along.transpose() / along.dot(&step_vector);
        Some((
            Sensitivity { columns, step: Some(step.to_vec()), ..sensitivity.clone() },
            rms_m(&change),
        ))
    }

    /// All large-amplitude sensitivities of a candidate.
    fn sensitivities_of(&self, sensitivity: &Sensitivity, base_m: &[f64]) -> Vec<Sensitivity> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        if candidate.is_scanned() {
            let scan = candidate.scan();
            let response = |&step: &f64| {
                let (response, _) = self.sensitivity_at(sensitivity, base_m, &[step])?;
                Some(ScanPoint {
                    step,
                    square: self.screen.residual_square((&response.columns * step).as_slice()),
                    response,
                })
            };
            return Self::refine_scan(
                scan.par_iter().filter_map(counted(&response)).collect(),
                &scan,
                &response,
            );
        }
        let Some(direction) = self.direction(sensitivity) else { return Vec::new() };
        let both = [1.0, -1.0].into_par_iter().map(|sign| sign * &direction);
        let responses = both
            .flat_map(counted(|direction| self.step_out(sensitivity, base_m, &direction)))
            .collect();
        self.refine(responses, base_m)
    }

    /// Sensitivities over a `scan`, refined on both sides of its best step.
    fn refine_scan(
        mut tried: Vec<ScanPoint>,
        scan: &[f64],
        response: &dyn Fn(&f64) -> Option<ScanPoint>,
    ) -> Vec<Sensitivity> {
        // Half of the narrowest spacing, so that refined steps stay between scanned ones.
        let mut step = scan.windows(2).map(|two| two[1] - two[0]).fold(scan[0].abs(), f64::min);
        for _ in 0..SCAN_BISECTIONS {
            step *= 0.5;
            let Some(best) = tried.iter().min_by(|a, b| a.square.total_cmp(&b.square)) else {
                break;
            };
            let neighbours = [best.step - step, best.step + step];
            tried.extend(neighbours.iter().filter_map(response));
        }
        tried.into_iter().map(|tried| tried.response).collect()
    }

    /// Search direction: the linear prediction, if there are several sizes.
    fn direction(&self, sensitivity: &Sensitivity) -> Option<DVector<f64>> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        match candidate.sizes()[..] {
            [size] => Some(DVector::from_element(1, candidate.probe(size).abs())),
            _ => Some(self.step(
                &self.screen.predictions(std::slice::from_ref(sensitivity)).pop()?.member,
                sensitivity,
            )),
        }
    }

    /// Change of the sizes from null to `member`.
    fn step(&self, member: &SetMember, sensitivity: &Sensitivity) -> DVector<f64> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        let each = candidate
            .sizes()
            .into_iter()
            .map(|size| candidate.step(&sensitivity.null, &member.values, size));
        DVector::from_vec(each.collect())
    }

    /// A step in units of the probes.
    fn in_probes(&self, sensitivity: &Sensitivity, step: &DVector<f64>) -> DVector<f64> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        let each = candidate
            .sizes()
            .into_iter()
            .zip(step.iter())
            .map(|(size, by)| by / candidate.probe(size));
        DVector::from_vec(each.collect())
    }

    /// Sensitivities at increasing steps until the tip moves far enough.
    fn step_out(
        &self,
        sensitivity: &Sensitivity,
        base_m: &[f64],
        direction: &DVector<f64>,
    ) -> Vec<Sensitivity> {
        let residual_m = rms_m(&self.residual_m);
        let max_size =
            MAX_AMPLITUDE / self.in_probes(sensitivity, direction).amax().max(f64::MIN_POSITIVE);
        let usual_m = rms_m((&sensitivity.columns * direction).as_slice());
        // The linear amount that would move the tip as far as the residual.
        let mut size = max_size.min(residual_m / usual_m.max(f64::MIN_POSITIVE));
        // Bracket: steps known to be too small and too large.
        let (mut too_small, mut too_large) = (0.0, f64::INFINITY);
        let mut responses = Vec::new();
        for _ in 0..MAX_SIMULATIONS {
            let Some((response, moved_m)) =
                self.sensitivity_at(sensitivity, base_m, (size * direction).as_slice())
            else {
                too_large = size;
                size = 0.5 * (too_small + too_large);
                continue;
            };
            responses.push(response);
            let ratio = residual_m / moved_m.max(f64::MIN_POSITIVE);
            if ACCEPTED_RATIO.contains(&ratio) || (ratio > 1.0 && size >= max_size) {
                break;
            }
            *(if ratio > 1.0 { &mut too_small } else { &mut too_large }) = size;
            // Secant in proportion; where it leaves the bracket, bisection.
            let next = max_size.min(size * ratio.clamp(0.25, 4.0));
            size = if next > too_small && next < too_large {
                next
            } else {
                0.5 * (too_small + too_large)
            };
        }
        responses
    }

    /// Sensitivities refined at the predicted optimum, as long as the newest one is the best.
    fn refine(&self, mut responses: Vec<Sensitivity>, base_m: &[f64]) -> Vec<Sensitivity> {
        let mut followed = responses.len();
        for _ in 0..MAX_REFINEMENTS {
            let predictions = self.screen.predictions_at_any_step(&responses).into_iter();
            let Some(best) = predictions.max_by(|a, b| a.gain.total_cmp(&b.gain)) else { break };
            let response = &responses[best.sensitivity];
            let Some(next) = response
                .step
                .as_ref()
                .and_then(|step| self.next_step(response, step, &best.member))
            else {
                break;
            };
            if std::mem::replace(&mut followed, best.sensitivity) == best.sensitivity {
                break;
            }
            let Some((refined, _)) = self.sensitivity_at(response, base_m, next.as_slice()) else {
                break;
            };
            responses.push(refined);
        }
        responses
    }

    /// Next step after one at `step` predicted `best`; none if that is close enough.
    fn next_step(
        &self,
        response: &Sensitivity,
        step: &[f64],
        best: &SetMember,
    ) -> Option<DVector<f64>> {
        let (there, wanted) = (DVector::from_column_slice(step), self.step(best, response));
        let size = |step: &DVector<f64>| self.in_probes(response, step).norm();
        // Beyond twice its own step a response predicts nothing.
        let max_size = MAX_AMPLITUDE.min(VALID_STEPS.end * size(&there));
        let wanted = &wanted * (max_size / size(&wanted).max(f64::MIN_POSITIVE)).min(1.0);
        (size(&(&wanted - there)) >= STEP_TOLERANCE * size(&wanted)).then_some(wanted)
    }

    /// Sensitivities that predict enough gain compared with those `others`.
    fn keep_relevant(
        &self,
        responses: Vec<Sensitivity>,
        others: &[Sensitivity],
    ) -> Vec<Sensitivity> {
        let predictions = self.screen.predictions(&responses);
        let mut rivals = self.screen.predictions(others);
        rivals.retain(|prediction| self.fit_problem.open[prediction.member.candidate]);
        let best =
            predictions.iter().chain(&rivals).map(|prediction| prediction.gain).fold(0.0, f64::max);
        // Two trials can mislead, so near misses are played in all of them as well.
        let min_gain = (MIN_GAIN_SHARE * best).min(best - MAX_GAIN_DEFICIT);
        let relevant = predictions.into_iter().filter(|prediction| prediction.gain >= min_gain);
        relevant.map(|prediction| responses[prediction.sensitivity].clone()).collect()
    }
}
