//! How well the parameters of an answer are known.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::gauss_newton::{FitProblem, FittedSet};
use crate::math::distribution::student_95;

/// Steps at most to an end of an interval, and how near to it, as a share, is near enough.
const PROFILED: usize = 5;
const NEAR_ENOUGH: f64 = 0.1;
/// Shares of the way to an end of an interval at which other numbers that fit as well are looked at.
const ON_THE_WAY: [f64; 3] = [1.0, 0.5, 0.25];
/// Looks beyond an end, …
const LOOKS: i32 = 5;
/// … and more of them as long as the last one fits as well, this far out, in units of the probes: a tendon that is slack is
/// as slack with any zero beyond.
const FAR: f64 = 10.0;

impl FitProblem<'_> {
    /// 95 % intervals of the parameters of member `k`, by their number in the card: what fits all but as well as the best
    /// fit, or as one with another choice does. A choice stands for half the way to its neighbours, the last one for as much
    /// on its far side.
    pub(crate) fn intervals(&self, best: &FittedSet, k: usize) -> BTreeMap<usize, [f64; 2]> {
        let reach = self.likelihood_radius(best);
        let mut found = BTreeMap::new();
        let mut widen = |parameter: usize, ends: [f64; 2]| {
            let known = found.entry(parameter).or_insert(ends);
            *known = [known[0].min(ends[0]), known[1].max(ends[1])];
        };
        self.profile_ends(best, k, reach).into_iter().for_each(|(parameter, ends)| widen(parameter, ends));
        let values = &best.members[k].values;
        for beside in self.candidates[best.members[k].candidate].neighbouring_choices(values) {
            let Some(parameter) = (0..values.len()).find(|&index| beside[index] != values[index]) else { continue };
            let towards = beside[parameter] - values[parameter];
            let half = 0.5 * towards.abs();
            widen(parameter, [values[parameter] - half, values[parameter] + half]);
            for (there, reach) in self.plausible_choices(best, k, parameter, towards, reach) {
                let choice = there.members[k].values[parameter];
                widen(parameter, [choice - half, choice + half]);
                self.profile_ends(&there, k, reach).into_iter().for_each(|(parameter, ends)| widen(parameter, ends));
            }
        }
        found
    }

    /// The sizes and shapes of member `k` at which the deviance is above that of `fitted` by less than the square of `reach`
    /// (profile likelihood; Venzon & Moolgavkar, Applied Statistics 37, 1988).
    fn profile_ends(&self, fitted: &FittedSet, k: usize, reach: f64) -> BTreeMap<usize, [f64; 2]> {
        let Some(covariance) = self.covariance(fitted) else { return BTreeMap::new() };
        let candidate = &self.candidates[fitted.members[k].candidate];
        let values = &fitted.members[k].values;
        let coordinates = self.coordinates(&fitted.members).into_iter().enumerate();
        let interval = |(at, (_, parameter)): (usize, (usize, usize))| {
            let end = |sign: f64| {
                let (_, step) = self.interval_end(fitted, &covariance, at, sign, reach);
                candidate.moved_within(values, parameter, sign * step * candidate.probe(parameter))[parameter]
            };
            let mut ends = [end(-1.0), end(1.0)];
            ends.sort_by(f64::total_cmp);
            (parameter, ends)
        };
        coordinates.filter(|(_, (member, _))| *member == k).map(interval).collect()
    }

    /// The root of what the deviance may rise by within a 95 % interval.
    fn likelihood_radius(&self, best: &FittedSet) -> f64 {
        student_95(3.0 * self.samples.len() as f64 - self.coordinates(&best.members).len() as f64)
    }

    /// The direction in which all coordinates go (in units of the probes) where coordinate `at` goes up or down by `sign`, and how
    /// far that may be until the deviance has risen by the square of `reach`.
    fn interval_end(
        &self,
        fitted: &FittedSet,
        covariance: &DMatrix<f64>,
        at: usize,
        sign: f64,
        reach: f64,
    ) -> (DVector<f64>, f64) {
        let variance = covariance[(at, at)].max(f64::MIN_POSITIVE);
        // The others go with it as the curvature at the best fit has them.
        let direction = covariance.column(at) * (sign / variance);
        let first = reach * variance.sqrt();
        let step = self.profile_step(fitted, at, &direction, (first, reach));
        let step = self.scan_beyond(fitted, at, &direction, (first, reach)).max(step);
        (direction, step)
    }

    /// Other numbers of the members that fit all but as well: every coordinate at the ends of its interval and on the way
    /// there, the others following.
    pub(crate) fn equally_good_fits(&self, best: &FittedSet) -> Vec<FittedSet> {
        let reach = self.likelihood_radius(best);
        let most = best.nuisance_fit.deviance + reach.powi(2);
        let Some(covariance) = self.covariance(best) else { return Vec::new() };
        let mut found = Vec::new();
        for (at, sign) in (0..covariance.ncols()).flat_map(|at| [(at, -1.0), (at, 1.0)]) {
            let (direction, step) = self.interval_end(best, &covariance, at, sign, reach);
            let there = |share: f64| self.evaluate(self.step_along(&best.members, at, &(share * step * &direction)).0);
            let others = ON_THE_WAY.into_iter().filter_map(there).filter(|other| other.nuisance_fit.deviance < most);
            found.extend(others.map(|other| FittedSet { jacobian: best.jacobian.clone(), ..other }));
        }
        found
    }

    /// How far coordinate `at` may go along a `direction` of all (in units of the probes): to `first`, where the curvature at
    /// the best fit has the deviance risen by the square of `reach`, or on to where it has, the others following. A little
    /// noise of the steps in time is in every deviance, and the best fit is where it is lowest: nothing ends before `first`
    /// but at the end of the range, or of what can be simulated_m.
    fn profile_step(&self, fitted: &FittedSet, at: usize, direction: &DVector<f64>, (first, reach): (f64, f64)) -> f64 {
        // The last step that was not far enough, and the root of the rise there.
        let mut last = (0.0, 0.0);
        let mut step = first;
        let (least, far_enough) = (fitted.nuisance_fit.deviance, (1.0 - NEAR_ENOUGH) * reach);
        for _ in 0..PROFILED {
            let (members, moved) = self.step_along(&fitted.members, at, &(step * direction));
            let is_the_end = moved.abs() < (1.0 - NEAR_ENOUGH) * step;
            let wanted = match last {
                // There it is enough to be simulated_m.
                _ if is_the_end => f64::NEG_INFINITY,
                // Whether `first` is far enough may show before all has been fitted there.
                (0.0, _) => least + far_enough.powi(2),
                _ => f64::INFINITY,
            };
            let Some(there) = self.fit_holding(fitted, at, members, wanted) else {
                step = 0.5 * (last.0 + step);
                continue;
            };
            if is_the_end {
                return moved.abs();
            }
            let root = (there.nuisance_fit.deviance - least).max(0.0).sqrt();
            if root >= far_enough {
                let beyond = if last.0 > 0.0 { (root - reach).max(0.0) / (root - last.1) } else { 0.0 };
                return step - beyond * (step - last.0);
            }
            last = (step, root);
            step *= (reach / root).min(2.0);
        }
        last.0
    }

    /// The farthest of some looks along the same direction, twice as far each time, at which the deviance is below that of an
    /// end of the interval, too: where the tip jumps (a rod that buckles) it rises and falls. Zero where there is none.
    fn scan_beyond(&self, fitted: &FittedSet, at: usize, direction: &DVector<f64>, (first, reach): (f64, f64)) -> f64 {
        let most = fitted.nuisance_fit.deviance + reach.powi(2);
        let mut farthest = 0.0;
        for doubled in 1.. {
            let step = first * 2.0_f64.powi(doubled);
            let (members, moved) = self.step_along(&fitted.members, at, &(step * direction));
            let fits =
                self.fit_holding(fitted, at, members, most).is_some_and(|there| there.nuisance_fit.deviance < most);
            if fits {
                farthest = moved.abs();
            }
            let is_the_end = moved.abs() < (1.0 - NEAR_ENOUGH) * step;
            if is_the_end || doubled >= LOOKS && !(fits && step < FAR) {
                break;
            }
        }
        farthest
    }

    /// Fits with other choices of `parameter` of member `k`, `towards` one side and interval_end as long as they fit all but as
    /// well, with what each leaves of `reach` (profile likelihood; Venzon & Moolgavkar, Applied Statistics 37, 1988).
    fn plausible_choices(
        &self,
        best: &FittedSet,
        k: usize,
        parameter: usize,
        towards: f64,
        reach: f64,
    ) -> Vec<(FittedSet, f64)> {
        let candidate = &self.candidates[best.members[k].candidate];
        let mut found: Vec<(FittedSet, f64)> = Vec::new();
        loop {
            let last = found.last().map_or(best, |(last, _)| last);
            let mut members = last.members.clone();
            let here = members[k].values[parameter];
            let mut beside = candidate.neighbouring_choices(&members[k].values).into_iter();
            let Some(next) = beside.find(|next| towards * (next[parameter] - here) > 0.0) else { return found };
            members[k].values = next;
            let Some(there) = self.refit(members, last.jacobian.clone()) else { return found };
            let square = reach * reach - (there.nuisance_fit.deviance - best.nuisance_fit.deviance);
            if square <= 0.0 {
                return found;
            }
            found.push((there, square.sqrt().min(reach)));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::data::Recording;
    use crate::discovery::fit::candidate::{CandidateEffect, SetMember, catalogue_candidates, effect_specs};
    use crate::discovery::fit::nuisance::Nuisances;
    use crate::discovery::fit::simulate;
    use crate::discovery::recording::samples::{Samples, white_noise};
    use crate::effects::Model;

    /// Fits the effect of this name to two trials of noise that it was hidden in with the `values`, and has a look.
    fn fitted<T>(
        name: &str,
        values: &[f64],
        seed: u64,
        look: impl Fn(&FitProblem, &CandidateEffect, &FittedSet) -> T,
    ) -> T {
        let model = Model::default();
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/twin/nothing.csv");
        let recording = Recording::read(&file).unwrap();
        let mut samples = Samples::new(&recording).of_trials(&[0, 1]);
        let candidates = catalogue_candidates(&model);
        let candidate = candidates.iter().position(|candidate| candidate.card.name == name).unwrap();
        let hidden = SetMember { candidate, values: values.to_vec() };
        let effects = effect_specs(&candidates, std::slice::from_ref(&hidden)).unwrap();
        let tips = simulate::tips(&model, &effects, &samples).unwrap();
        let mut noise = white_noise(5e-4, seed);
        for (row, tip) in samples.rows.iter_mut().zip(tips.chunks_exact(3)) {
            row.tip_m = [tip[0] + noise(), tip[1] + noise(), tip[2] + noise()];
        }
        let nuisances = Nuisances::independent(3 * samples.len(), &[]);
        let open = vec![true; candidates.len()];
        let (model, samples) = (&model, &samples);
        let fit_problem =
            FitProblem { model, coarse: model, candidates: &candidates, open, samples, nuisances: &nuisances };
        let fitted = fit_problem.fit(vec![hidden]).unwrap();
        look(&fit_problem, &candidates[candidate], &fitted)
    }

    #[test]
    fn an_interval_ends_where_the_deviance_has_risen() {
        fitted("creep", &[0.3, 8.0], 1, |fit_problem, candidate, fitted| {
            let (value, ends) = (fitted.members[0].values[1], fit_problem.intervals(fitted, 0)[&1]);
            let covariance = fit_problem.covariance(fitted).unwrap();
            let together = covariance.column(1) / covariance[(1, 1)];
            let curved = 1.96 * covariance[(1, 1)].sqrt();
            for end in ends {
                let step = (end / value).ln() / candidate.probe(1);
                let (members, moved) = fit_problem.step_along(&fitted.members, 1, &(step * &together));
                let there = fit_problem.fit_holding(fitted, 1, members, f64::INFINITY).unwrap();
                assert!((moved / step - 1.0).abs() < 1e-6 && step.abs() > 0.99 * curved, "{value}: {ends:?}");
                let rise = there.nuisance_fit.deviance - fitted.nuisance_fit.deviance;
                assert!(rise > 0.75 * 1.96_f64.powi(2), "{value}: {ends:?}, {rise}");
                assert!(step.abs() < 1.05 * curved || rise < 1.25 * 1.96_f64.powi(2), "{value}: {ends:?}, {rise}");
            }
        });
    }

    #[test]
    fn an_interval_ends_where_the_effect_does() {
        // A tenth of a gram, known to a sixth of one: no mass is negative.
        let [low, high] =
            fitted("tip_load", &[0.0001], 1, |fit_problem, _, fitted| fit_problem.intervals(fitted, 0)[&0]);
        assert!(low == 0.0 && high > 1e-4, "{low} to {high}");
    }
}
