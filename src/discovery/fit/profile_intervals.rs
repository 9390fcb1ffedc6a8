//! 95 % intervals of fitted parameters by profile likelihood.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::candidate::neighbouring_choices;
use super::gauss_newton::{FitProblem, FittedSet};
use crate::math::distribution::student_95;

/// Maximum steps to an end of an interval, and relative tolerance of the end.
const MAX_PROFILE_STEPS: usize = 5;
const END_TOLERANCE: f64 = 0.1;
/// Fractions of the way to an end at which other equally good values are evaluated.
const EVALUATED_SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// Evaluations beyond an end, each twice as far out (docs/method/search.md, "Intervals") …
const MAX_DOUBLINGS: i32 = 5;
/// … and more as long as the last one fits, up to this distance in probes: a slack tendon stays
/// slack for any larger zero.
const MAX_DISTANCE: f64 = 10.0;

/// The profile of the deviance along one coordinate of a fit.
struct Profile<'a> {
    fitted: &'a FittedSet,
    coordinate: usize,
    /// Direction of all coordinates in probes: the others follow by the curvature at the best fit.
    direction: DVector<f64>,
    /// Quadratic prediction of the distance to the end of the interval.
    predicted: f64,
    /// Root of the increase of the deviance at the end.
    radius: f64,
}

impl FitProblem<'_> {
    /// 95 % intervals of the parameters of member `k`, by parameter index. A choice covers half the
    /// distance to its neighbours; the last one extends equally far outwards.
    pub(crate) fn intervals(&self, best: &FittedSet, k: usize) -> BTreeMap<usize, [f64; 2]> {
        let radius = self.likelihood_radius(best);
        let mut intervals = BTreeMap::new();
        let mut widen = |parameter: usize, ends: [f64; 2]| {
            let interval = intervals.entry(parameter).or_insert(ends);
            *interval = [interval[0].min(ends[0]), interval[1].max(ends[1])];
        };
        self.profile_ends(best, k, radius)
            .into_iter()
            .for_each(|(parameter, ends)| widen(parameter, ends));
        let values = &best.members[k].values;
        // A choice has no derivative: its interval is that of the choices that fit nearly as well.
        for beside in neighbouring_choices(self.candidates, &best.members, k) {
            let Some(parameter) = (0..values.len()).find(|&index| beside[index] != values[index])
            else {
                continue;
            };
            let towards = beside[parameter] - values[parameter];
            let half = 0.5 * towards.abs();
            widen(parameter, [values[parameter] - half, values[parameter] + half]);
            for (there, radius) in self.plausible_choices(best, k, parameter, towards, radius) {
                let choice = there.members[k].values[parameter];
                widen(parameter, [choice - half, choice + half]);
                self.profile_ends(&there, k, radius)
                    .into_iter()
                    .for_each(|(parameter, ends)| widen(parameter, ends));
            }
        }
        intervals
    }

    /// Ends of the sizes and shapes of member `k` at which the profile deviance exceeds that of
    /// `fitted` by `radius` squared (profile likelihood; Venzon & Moolgavkar, Applied Statistics
    /// 37, 1988).
    fn profile_ends(&self, fitted: &FittedSet, k: usize, radius: f64) -> BTreeMap<usize, [f64; 2]> {
        let Some(covariance) = self.covariance(fitted) else { return BTreeMap::new() };
        let candidate = &self.candidates[fitted.members[k].candidate];
        let values = &fitted.members[k].values;
        let coordinates = self.coordinates(&fitted.members).into_iter().enumerate();
        let interval = |(at, (_, parameter)): (usize, (usize, usize))| {
            let end = |sign: f64| {
                // Venzon & Moolgavkar start from the quadratic prediction, too.
                let step = self.interval_end(&Profile::new(fitted, &covariance, at, sign, radius));
                candidate.moved_within(values, parameter, sign * step * candidate.probe(parameter))
                    [parameter]
            };
            let mut ends = [end(-1.0), end(1.0)];
            ends.sort_by(f64::total_cmp);
            (parameter, ends)
        };
        coordinates.filter(|(_, (member, _))| *member == k).map(interval).collect()
    }

    /// Square root of the admissible increase of the deviance in a 95 % interval.
    fn likelihood_radius(&self, best: &FittedSet) -> f64 {
        student_95(3.0 * self.samples.len() as f64 - self.coordinates(&best.members).len() as f64)
    }

    /// Distance along a profile at which the deviance has risen to that of the end, for good.
    fn interval_end(&self, profile: &Profile) -> f64 {
        let step = self.profile_step(profile);
        self.scan_beyond(profile).max(step)
    }

    /// Other values within the intervals that fit almost equally well.
    pub(crate) fn equally_good_fits(&self, best: &FittedSet) -> Vec<FittedSet> {
        let radius = self.likelihood_radius(best);
        let max_deviance = best.nuisance_fit.deviance + radius.powi(2);
        let Some(covariance) = self.covariance(best) else { return Vec::new() };
        let mut fits = Vec::new();
        for (at, sign) in (0..covariance.ncols()).flat_map(|at| [(at, -1.0), (at, 1.0)]) {
            let profile = Profile::new(best, &covariance, at, sign, radius);
            let step = self.interval_end(&profile);
            let evaluate = |share: f64| {
                self.evaluate(
                    self.step_along(&best.members, at, &(share * step * &profile.direction)).0,
                )
            };
            let others = EVALUATED_SHARES.into_iter().filter_map(evaluate);
            let others = others.filter(|other| other.nuisance_fit.deviance < max_deviance);
            fits.extend(others.map(|other| FittedSet { jacobian: best.jacobian.clone(), ..other }));
        }
        fits
    }

    /// Distance along a profile until the deviance has risen, by secant steps from the quadratic
    /// prediction. Time-stepping noise lowers the deviance at the best fit, so no interval ends
    /// before the prediction except at the end of the valid range or of what can be simulated.
    fn profile_step(&self, profile: &Profile) -> f64 {
        let &Profile { fitted, coordinate, ref direction, predicted, radius } = profile;
        // Last step that was too short, and the root of its increase.
        let mut last = (0.0, 0.0);
        let mut step = predicted;
        let (min_deviance, min_root) =
            (fitted.nuisance_fit.deviance, (1.0 - END_TOLERANCE) * radius);
        for _ in 0..MAX_PROFILE_STEPS {
            let (members, moved) =
                self.step_along(&fitted.members, coordinate, &(step * direction));
            let is_the_end = moved.abs() < (1.0 - END_TOLERANCE) * step;
            let target_deviance = match last {
                // At the end of the range the simulation alone decides.
                _ if is_the_end => f64::NEG_INFINITY,
                // An incomplete fit may already show that the prediction is far enough.
                (0.0, _) => min_deviance + min_root.powi(2),
                _ => f64::INFINITY,
            };
            let Some(there) = self.fit_holding(fitted, coordinate, members, target_deviance) else {
                // Too far to be simulated: halve the way back.
                step = 0.5 * (last.0 + step);
                continue;
            };
            if is_the_end {
                return moved.abs();
            }
            let root = (there.nuisance_fit.deviance - min_deviance).max(0.0).sqrt();
            if root >= min_root {
                // Interpolate the root of the deviance, which a quadratic makes linear in the step.
                let beyond =
                    if last.0 > 0.0 { (root - radius).max(0.0) / (root - last.1) } else { 0.0 };
                return step - beyond * (step - last.0);
            }
            last = (step, root);
            // At most double: beyond a jump the secant would leap far past the end.
            step *= (radius / root).min(2.0);
        }
        last.0
    }

    /// Farthest evaluation beyond the end, doubling each time, with a deviance below that of the
    /// end: where the tip jumps (a buckling rod) the deviance is not monotonic. Zero if there is
    /// none.
    fn scan_beyond(&self, profile: &Profile) -> f64 {
        let &Profile { fitted, coordinate, ref direction, predicted, radius } = profile;
        let max_deviance = fitted.nuisance_fit.deviance + radius.powi(2);
        let mut farthest = 0.0;
        for doublings in 1.. {
            let step = predicted * 2.0_f64.powi(doublings);
            let (members, moved) =
                self.step_along(&fitted.members, coordinate, &(step * direction));
            let there = self.fit_holding(fitted, coordinate, members, max_deviance);
            let fits = there.is_some_and(|there| there.nuisance_fit.deviance < max_deviance);
            if fits {
                farthest = moved.abs();
            }
            let is_the_end = moved.abs() < (1.0 - END_TOLERANCE) * step;
            if is_the_end || doublings >= MAX_DOUBLINGS && !(fits && step < MAX_DISTANCE) {
                break;
            }
        }
        farthest
    }

    /// Fits with other choices of `parameter` of member `k`, `towards` one side as long as they fit
    /// almost equally well, each with the remaining `radius` (profile likelihood; Venzon &
    /// Moolgavkar, Applied Statistics 37, 1988).
    fn plausible_choices(
        &self,
        best: &FittedSet,
        k: usize,
        parameter: usize,
        towards: f64,
        radius: f64,
    ) -> Vec<(FittedSet, f64)> {
        let mut choices: Vec<(FittedSet, f64)> = Vec::new();
        loop {
            let last = choices.last().map_or(best, |(last, _)| last);
            let mut members = last.members.clone();
            let here = members[k].values[parameter];
            let mut beside = neighbouring_choices(self.candidates, &members, k).into_iter();
            let Some(next) = beside.find(|next| towards * (next[parameter] - here) > 0.0) else {
                return choices;
            };
            members[k].values = next;
            let Some(there) = self.refit(members, last.jacobian.clone()) else { return choices };
            // What the choice has already used of the admissible rise is gone for its other
            // numbers.
            let square =
                radius * radius - (there.nuisance_fit.deviance - best.nuisance_fit.deviance);
            if square <= 0.0 {
                return choices;
            }
            choices.push((there, square.sqrt().min(radius)));
        }
    }
}

impl<'a> Profile<'a> {
    /// Of a `coordinate` as it moves by `sign`.
    fn new(
        fitted: &'a FittedSet,
        covariance: &DMatrix<f64>,
        coordinate: usize,
        sign: f64,
        radius: f64,
    ) -> Profile<'a> {
        let variance = covariance[(coordinate, coordinate)].max(f64::MIN_POSITIVE);
        // Along this direction the others are refitted to first order.
        let direction = covariance.column(coordinate) * (sign / variance);
        Profile { fitted, coordinate, direction, predicted: radius * variance.sqrt(), radius }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::data::Recording;
    use crate::discovery::fit::candidate::{
        CandidateEffect, SetMember, catalogue_candidates, effect_specs,
    };
    use crate::discovery::fit::nuisance::Nuisances;
    use crate::discovery::fit::simulate;
    use crate::discovery::recording::samples::{Samples, white_noise};
    use crate::effects::Model;

    /// Fits an effect to two trials of noise and this effect with these `values`, and evaluates the
    /// fit.
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
        let candidate =
            candidates.iter().position(|candidate| candidate.card.name == name).unwrap();
        let hidden = SetMember { candidate, values: values.to_vec() };
        let effects = effect_specs(&candidates, std::slice::from_ref(&hidden)).unwrap();
        let tips = simulate::tips(&model, &effects, &samples).unwrap();
        let mut noise = white_noise(5e-4, seed);
        for (row, tip) in samples.rows.iter_mut().zip(tips.chunks_exact(3)) {
            row.position_m = [tip[0] + noise(), tip[1] + noise(), tip[2] + noise()];
        }
        let nuisances = Nuisances::independent(3 * samples.len(), &[]);
        let open = vec![true; candidates.len()];
        let (model, samples) = (&model, &samples);
        let fit_problem = FitProblem {
            model,
            coarse: model,
            candidates: &candidates,
            open,
            samples,
            nuisances: &nuisances,
        };
        let fitted = fit_problem.fit(vec![hidden]).unwrap();
        look(&fit_problem, &candidates[candidate], &fitted)
    }

    #[test]
    fn an_interval_ends_where_the_deviance_has_risen() {
        fitted("creep", &[0.3, 8.0, 0.0], 1, |fit_problem, candidate, fitted| {
            let (value, ends) = (fitted.members[0].values[1], fit_problem.intervals(fitted, 0)[&1]);
            let covariance = fit_problem.covariance(fitted).unwrap();
            let together = covariance.column(1) / covariance[(1, 1)];
            let curved = 1.96 * covariance[(1, 1)].sqrt();
            for end in ends {
                let step = (end / value).ln() / candidate.probe(1);
                let (members, moved) =
                    fit_problem.step_along(&fitted.members, 1, &(step * &together));
                let there = fit_problem.fit_holding(fitted, 1, members, f64::INFINITY).unwrap();
                assert!(
                    (moved / step - 1.0).abs() < 1e-6 && step.abs() > 0.99 * curved,
                    "{value}: {ends:?}"
                );
                let rise = there.nuisance_fit.deviance - fitted.nuisance_fit.deviance;
                assert!(rise > 0.75 * 1.96_f64.powi(2), "{value}: {ends:?}, {rise}");
                assert!(
                    step.abs() < 1.05 * curved || rise < 1.25 * 1.96_f64.powi(2),
                    "{value}: {ends:?}, {rise}"
                );
            }
        });
    }

    #[test]
    fn an_interval_ends_where_the_effect_does() {
        // A tenth of a gram: the interval ends at zero mass.
        let [low, high] = fitted("tip_load", &[0.0001], 1, |fit_problem, _, fitted| {
            fit_problem.intervals(fitted, 0)[&0]
        });
        assert!(low == 0.0 && high > 1e-4, "{low} to {high}");
    }
}
