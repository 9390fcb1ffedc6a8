//! Large-amplitude sensitivities: the response of the tip to a large amount of an effect, or to one of the other sign,
//! can differ from the linear one (a softer rod sags until tendons are taut; a stiffer one does not).
//!
//! The trials with the largest residual decide which of these sensitivities matter; only these are simulated on all
//! trials.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;

use super::screening::{ALIKE, LinearScreen, best_of_each};
use crate::discovery::fit::candidate::{CandidateEffect, SetMember, effect_specs};
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::sensitivities::{Sensitivity, sensitivities};
use crate::discovery::fit::simulate::tips;
use crate::discovery::recording::samples::{Samples, rms_m};

/// Maximum amplitude in usual sizes.
const FARTHEST: f64 = 8.0;
/// Maximum number of simulations to find the amplitude that moves the tip as far as the residual.
const LOOKS: usize = 5;
/// Accepted ratio of the tip displacement to the residual.
const NEAR_ENOUGH: Range<f64> = 0.5..2.0;
/// Refinements near the predicted optimum, and their tolerance.
const NEARER: usize = 3;
const THERE: f64 = 0.2;
/// Bisections of a scan about its best step.
const HALVED: usize = 2;
/// Number of trials used first.
const SHOWN: usize = 2;
/// A sensitivity is kept if it predicts this share of the best gain, or a gain this close to it.
const WORTH_SHARE: f64 = 0.2;
const WORTH_SLACK: f64 = 10.0;

impl FitProblem<'_> {
    /// Sensitivities to each candidate relative to `base`, in both directions, at the amplitude that would move the
    /// tip as far as the residual of `base`, refined towards the best fit. For each candidate the variant with the
    /// best prediction is used. Candidates that are scanned are evaluated over their whole range.
    pub(crate) fn large_amplitude_sensitivities(
        &self,
        base: &FittedSet,
        sensitivities: &[Sensitivity],
    ) -> Vec<Sensitivity> {
        let all = LargeAmplitudeScreen::new(self, base, &(0..self.samples.trials.len()).collect::<Vec<usize>>());
        let some = LargeAmplitudeScreen::new(self, base, &self.largest_residual_trials(base));
        let (Some(here), Some(there)) = (some.simulate(&[]), all.simulate(&[])) else { return Vec::new() };
        let beside = some.sensitivities_beside_base(&|_| true);
        let (known, predictions) = if beside.is_empty() {
            (
                sensitivities.iter().map(|sensitivity| some.restricted(sensitivity)).collect(),
                self.predictions(base, &[], sensitivities),
            )
        } else {
            let predictions = best_of_each(some.screen.predictions(&beside));
            (beside, predictions)
        };
        let little = |of: &Sensitivity| known.iter().find(|sensitivity| sensitivity.is_small_step_of(of));
        let promised = predictions.iter().filter_map(|prediction| little(&known[prediction.sensitivity]));
        let mut seen = vec![false; self.candidates.len()];
        base.members.iter().for_each(|member| seen[member.candidate] = true);
        let begun: Vec<&Sensitivity> = promised
            .chain(known.iter().filter_map(little))
            .filter(|sensitivity| self.open[sensitivity.candidate])
            .filter(|sensitivity| !std::mem::replace(&mut seen[sensitivity.candidate], true))
            .collect();
        let looks: Vec<Sensitivity> =
            begun.into_par_iter().flat_map(|sensitivity| some.sensitivities_of(sensitivity, &here)).collect();
        let worth = some.keep_relevant(looks, &known);
        // The update corrects the sensitivity in one direction only; the other columns hold relative to the base.
        let wide = |candidate: &CandidateEffect| {
            let of = |look: &Sensitivity| std::ptr::eq(candidate, &self.candidates[look.candidate]);
            candidate.sizes().len() > 1 && worth.iter().any(of)
        };
        let beside = all.sensitivities_beside_base(&wide);
        let everywhere = |look: &Sensitivity| {
            let little = beside.iter().chain(sensitivities).find(|sensitivity| sensitivity.is_small_step_of(look))?;
            Some(all.sensitivity_at(little, &there, look.step.as_ref()?)?.0)
        };
        worth.par_iter().filter_map(everywhere).collect()
    }

    /// The trials with the largest residual.
    fn largest_residual_trials(&self, base: &FittedSet) -> Vec<usize> {
        let ranges = self.samples.ranges();
        let left = |trial: usize| -> f64 {
            base.nuisance_fit.residual_m[3 * ranges[trial].start..3 * ranges[trial].end]
                .iter()
                .map(|left| left * left)
                .sum()
        };
        let mut trials: Vec<usize> = (0..ranges.len()).collect();
        trials.sort_by(|&a, &b| left(b).total_cmp(&left(a)));
        trials.truncate(SHOWN);
        trials
    }
}

/// One step of a scan with its remaining sum of squares.
struct ScanPoint {
    step: f64,
    left: f64,
    look: Sensitivity,
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
    fn new(fit_problem: &'a FitProblem<'a>, base: &'a FittedSet, trials: &[usize]) -> LargeAmplitudeScreen<'a> {
        let ranges = fit_problem.samples.ranges();
        let rows: Vec<usize> =
            trials.iter().flat_map(|&trial| 3 * ranges[trial].start..3 * ranges[trial].end).collect();
        let samples = fit_problem.samples.of_trials(trials);
        let residual_m: Vec<f64> = rows.iter().map(|&row| base.nuisance_fit.residual_m[row]).collect();
        let nuisances = fit_problem.nuisances.in_rows(&rows);
        let held = base.jacobian.select_rows(&rows);
        let screen = LinearScreen::new(
            fit_problem.candidates,
            &samples,
            &nuisances,
            (&base.nuisance_fit.noise, &residual_m),
            &held,
        );
        LargeAmplitudeScreen { fit_problem, base, samples, rows, residual_m, screen }
    }

    /// A sensitivity restricted to these samples.
    fn restricted(&self, sensitivity: &Sensitivity) -> Sensitivity {
        Sensitivity { columns: sensitivity.columns.select_rows(&self.rows), ..sensitivity.clone() }
    }

    /// Sensitivities relative to the members of the base: they can change which tendons are taut.
    fn sensitivities_beside_base(&self, asked: &(dyn Fn(&CandidateEffect) -> bool + Sync)) -> Vec<Sensitivity> {
        let (fit_problem, members) = (self.fit_problem, &self.base.members);
        let asked = |candidate: &CandidateEffect| !members.is_empty() && asked(candidate);
        sensitivities(fit_problem.coarse, fit_problem.candidates, members, &asked, &self.samples)
    }

    /// Simulated tip of the coarse model with the members of the base and `more`.
    fn simulate(&self, more: &[crate::effects::EffectSpec]) -> Option<Vec<f64>> {
        let known = effect_specs(self.fit_problem.candidates, &self.base.members)?;
        tips(self.fit_problem.coarse, &[&known, more].concat(), &self.samples)
    }

    /// `sensitivity` corrected at `step` (Broyden's update, in probes), and the tip displacement; none if it cannot be
    /// simulated.
    fn sensitivity_at(&self, sensitivity: &Sensitivity, here: &[f64], step: &[f64]) -> Option<(Sensitivity, f64)> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        let sizes = candidate.sizes();
        let effect = candidate.effect(&candidate.with_sizes(&sensitivity.null, step))?;
        let change: Vec<f64> = self.simulate(&[effect])?.iter().zip(here).map(|(there, here)| there - here).collect();
        let by = DVector::from_column_slice(step);
        let along = DVector::from_iterator(
            step.len(),
            sizes.iter().zip(step).map(|(&size, by)| by / candidate.probe(size).powi(2)),
        );
        let missed = DVector::from_column_slice(&change) - &sensitivity.columns * &by;
        let columns = &sensitivity.columns + missed * along.transpose() / along.dot(&by);
        Some((Sensitivity { columns, step: Some(step.to_vec()), ..sensitivity.clone() }, rms_m(&change)))
    }

    /// All large-amplitude sensitivities of a candidate.
    fn sensitivities_of(&self, sensitivity: &Sensitivity, here: &[f64]) -> Vec<Sensitivity> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        if candidate.is_scanned() {
            let scan = candidate.scan();
            let look = |&step: &f64| {
                let (look, _) = self.sensitivity_at(sensitivity, here, &[step])?;
                Some(ScanPoint { step, left: self.screen.residual_square((&look.columns * step).as_slice()), look })
            };
            return Self::refine_scan(scan.par_iter().filter_map(look).collect(), &scan, &look);
        }
        let Some(direction) = self.direction(sensitivity) else { return Vec::new() };
        let both = [1.0, -1.0].into_par_iter().map(|sign| sign * &direction);
        let looks = both.flat_map(|direction| self.step_out(sensitivity, here, &direction)).collect();
        self.refine(looks, here)
    }

    /// Sensitivities over a `scan`, refined on both sides of its best step.
    fn refine_scan(
        mut tried: Vec<ScanPoint>,
        scan: &[f64],
        look: &dyn Fn(&f64) -> Option<ScanPoint>,
    ) -> Vec<Sensitivity> {
        let mut apart = scan.windows(2).map(|two| two[1] - two[0]).fold(scan[0].abs(), f64::min);
        for _ in 0..HALVED {
            apart *= 0.5;
            let Some(best) = tried.iter().min_by(|a, b| a.left.total_cmp(&b.left)) else { break };
            let beside = [best.step - apart, best.step + apart];
            tried.extend(beside.iter().filter_map(look));
        }
        tried.into_iter().map(|tried| tried.look).collect()
    }

    /// Search direction: the linear prediction, if there are several sizes.
    fn direction(&self, sensitivity: &Sensitivity) -> Option<DVector<f64>> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        match candidate.sizes()[..] {
            [size] => Some(DVector::from_element(1, candidate.probe(size).abs())),
            _ => {
                Some(self.step(&self.screen.predictions(std::slice::from_ref(sensitivity)).pop()?.member, sensitivity))
            }
        }
    }

    /// Change of the sizes from null to `member`.
    fn step(&self, member: &SetMember, sensitivity: &Sensitivity) -> DVector<f64> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        let each = candidate.sizes().into_iter().map(|size| candidate.step(&sensitivity.null, &member.values, size));
        DVector::from_vec(each.collect())
    }

    /// A step in units of the probes.
    fn in_probes(&self, sensitivity: &Sensitivity, step: &DVector<f64>) -> DVector<f64> {
        let candidate = &self.fit_problem.candidates[sensitivity.candidate];
        let each = candidate.sizes().into_iter().zip(step.iter()).map(|(size, by)| by / candidate.probe(size));
        DVector::from_vec(each.collect())
    }

    /// Sensitivities at increasing steps until the tip moves far enough.
    fn step_out(&self, sensitivity: &Sensitivity, here: &[f64], direction: &DVector<f64>) -> Vec<Sensitivity> {
        let residual_m = rms_m(&self.residual_m);
        let farthest = FARTHEST / self.in_probes(sensitivity, direction).amax().max(f64::MIN_POSITIVE);
        let usual_m = rms_m((&sensitivity.columns * direction).as_slice());
        let mut size = farthest.min(residual_m / usual_m.max(f64::MIN_POSITIVE));
        // Bracket: steps known to be too small and too large.
        let (mut little, mut much) = (0.0, f64::INFINITY);
        let mut found = Vec::new();
        for _ in 0..LOOKS {
            let Some((seen, moved_m)) = self.sensitivity_at(sensitivity, here, (size * direction).as_slice()) else {
                much = size;
                size = 0.5 * (little + much);
                continue;
            };
            found.push(seen);
            let wanted = residual_m / moved_m.max(f64::MIN_POSITIVE);
            if NEAR_ENOUGH.contains(&wanted) || (wanted > 1.0 && size >= farthest) {
                break;
            }
            *(if wanted > 1.0 { &mut little } else { &mut much }) = size;
            let next = farthest.min(size * wanted.clamp(0.25, 4.0));
            size = if next > little && next < much { next } else { 0.5 * (little + much) };
        }
        found
    }

    /// Sensitivities refined at the predicted optimum, as long as the newest one is the best.
    fn refine(&self, mut looks: Vec<Sensitivity>, here: &[f64]) -> Vec<Sensitivity> {
        let mut followed = looks.len();
        for _ in 0..NEARER {
            let predictions = self.screen.predictions_at_any_step(&looks).into_iter();
            let Some(best) = predictions.max_by(|a, b| a.gain.total_cmp(&b.gain)) else { break };
            let look = &looks[best.sensitivity];
            let Some(next) = look.step.as_ref().and_then(|step| self.next_step(look, step, &best.member)) else {
                break;
            };
            if std::mem::replace(&mut followed, best.sensitivity) == best.sensitivity {
                break;
            }
            let Some((seen, _)) = self.sensitivity_at(look, here, next.as_slice()) else { break };
            looks.push(seen);
        }
        looks
    }

    /// Next step after one at `step` predicted `best`; none if that is close enough.
    fn next_step(&self, look: &Sensitivity, step: &[f64], best: &SetMember) -> Option<DVector<f64>> {
        let (there, wanted) = (DVector::from_column_slice(step), self.step(best, look));
        let size = |step: &DVector<f64>| self.in_probes(look, step).norm();
        let most = FARTHEST.min(ALIKE.end * size(&there));
        let wanted = &wanted * (most / size(&wanted).max(f64::MIN_POSITIVE)).min(1.0);
        (size(&(&wanted - there)) >= THERE * size(&wanted)).then_some(wanted)
    }

    /// Sensitivities that predict enough gain compared with those `known`.
    fn keep_relevant(&self, looks: Vec<Sensitivity>, known: &[Sensitivity]) -> Vec<Sensitivity> {
        let found = self.screen.predictions(&looks);
        let mut rivals = self.screen.predictions(known);
        rivals.retain(|prediction| self.fit_problem.open[prediction.member.candidate]);
        let best = found.iter().chain(&rivals).map(|prediction| prediction.gain).fold(0.0, f64::max);
        let least = (WORTH_SHARE * best).min(best - WORTH_SLACK);
        let kept = found.into_iter().filter(|prediction| prediction.gain >= least);
        kept.map(|prediction| looks[prediction.sensitivity].clone()).collect()
    }
}
