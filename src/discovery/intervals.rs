//! How well the parameters of an answer are known.

use std::collections::BTreeMap;

use super::refit::{Fitted, Study};
use crate::math::distribution::student_95;

/// Steps at most to an end of an interval, and how near to it, as a share, is near enough.
const PROFILED: usize = 4;
const NEAR_ENOUGH: f64 = 0.1;

impl Study<'_> {
    /// 95 % intervals of the parameters of member `k`, by their number in the card: what is within so many standard
    /// deviations of the best fit, or of one with another choice that fits all but as well. A choice stands for half the
    /// way to its neighbours, the last one for as much on its far side.
    pub(super) fn intervals(&self, best: &Fitted, k: usize) -> BTreeMap<usize, [f64; 2]> {
        let freedom = 3.0 * self.samples.len() as f64 - self.coordinates(&best.members).len() as f64;
        let reach = student_95(freedom);
        let mut found = BTreeMap::new();
        let mut widen = |parameter: usize, ends: [f64; 2]| {
            let known = found.entry(parameter).or_insert(ends);
            *known = [known[0].min(ends[0]), known[1].max(ends[1])];
        };
        self.within(best, k, reach).into_iter().for_each(|(parameter, ends)| widen(parameter, ends));
        let values = &best.members[k].values;
        for beside in self.hypotheses[best.members[k].hypothesis].neighbours(values) {
            let Some(parameter) = (0..values.len()).find(|&index| beside[index] != values[index]) else { continue };
            let towards = beside[parameter] - values[parameter];
            let half = 0.5 * towards.abs();
            widen(parameter, [values[parameter] - half, values[parameter] + half]);
            for (there, reach) in self.plausible(best, k, parameter, towards, reach) {
                let choice = there.members[k].values[parameter];
                widen(parameter, [choice - half, choice + half]);
                self.within(&there, k, reach).into_iter().for_each(|(parameter, ends)| widen(parameter, ends));
            }
        }
        found
    }

    /// The sizes and shapes of member `k` within `reach` standard deviations.
    fn within(&self, fitted: &Fitted, k: usize, reach: f64) -> BTreeMap<usize, [f64; 2]> {
        let Some(covariance) = self.covariance(fitted) else { return BTreeMap::new() };
        let hypothesis = &self.hypotheses[fitted.members[k].hypothesis];
        let values = &fitted.members[k].values;
        let coordinates = self.coordinates(&fitted.members).into_iter().enumerate();
        let interval = |(at, (_, parameter)): (usize, (usize, usize))| {
            let half = reach * covariance[(at, at)].max(0.0).sqrt();
            let end = |step: f64| {
                let step = self.profiled(fitted, at, step, reach);
                hypothesis.moved(values, parameter, step * hypothesis.probe(parameter))[parameter]
            };
            let mut ends = [end(-half), end(half)];
            ends.sort_by(f64::total_cmp);
            (parameter, ends)
        };
        coordinates.filter(|(_, (member, _))| *member == k).map(interval).collect()
    }

    /// How far coordinate `at` may go, `step` (in units of its probe) or more or less, until the deviance has risen by the
    /// square of `reach`, all others following (profile likelihood; Venzon & Moolgavkar, Applied Statistics 37, 1988).
    fn profiled(&self, fitted: &Fitted, at: usize, mut step: f64, reach: f64) -> f64 {
        for _ in 0..PROFILED {
            let Some(there) = self.held(fitted, at, step) else { return step };
            let rise = (there.explained.deviance - fitted.explained.deviance).max(f64::MIN_POSITIVE);
            let next = step * (reach / rise.sqrt()).clamp(0.5, 2.0);
            if (next / step - 1.0).abs() < NEAR_ENOUGH {
                return next;
            }
            step = next;
        }
        step
    }

    /// Fits with other choices of `parameter` of member `k`, `towards` one side and outwards as long as they fit all but as
    /// well, with what each leaves of `reach` (profile likelihood; Venzon & Moolgavkar, Applied Statistics 37, 1988).
    fn plausible(&self, best: &Fitted, k: usize, parameter: usize, towards: f64, reach: f64) -> Vec<(Fitted, f64)> {
        let hypothesis = &self.hypotheses[best.members[k].hypothesis];
        let mut found: Vec<(Fitted, f64)> = Vec::new();
        loop {
            let last = found.last().map_or(best, |(last, _)| last);
            let mut members = last.members.clone();
            let here = members[k].values[parameter];
            let mut beside = hypothesis.neighbours(&members[k].values).into_iter();
            let Some(next) = beside.find(|next| towards * (next[parameter] - here) > 0.0) else { return found };
            members[k].values = next;
            let Some(there) = self.refit(members, last.jacobian.clone()) else { return found };
            let square = reach * reach - (there.explained.deviance - best.explained.deviance);
            if square <= 0.0 {
                return found;
            }
            found.push((there, square.sqrt().min(reach)));
        }
    }
}
