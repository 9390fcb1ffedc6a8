//! Hypotheses fitted to the samples: the physics played anew at every step, nuisances and noise with it.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::candidate::{Hypothesis, Member, effects};
use super::nuisance::{Explained, Nuisances};
use super::simulate::tips;
use crate::discovery::recording::samples::Samples;
use crate::effects::Model;

/// What hypotheses are fitted to.
#[derive(Clone)]
pub(crate) struct Study<'a> {
    pub(crate) model: &'a Model,
    /// The model played coarsely, for rough fits.
    pub(crate) coarse: &'a Model,
    pub(crate) hypotheses: &'a [Hypothesis],
    /// Which of them may be the answer.
    pub(crate) open: Vec<bool>,
    pub(crate) samples: &'a Samples,
    pub(crate) nuisances: &'a Nuisances,
}

/// Hypotheses with the values that fit best.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) members: Vec<Member>,
    /// What is left of the residual.
    pub(crate) explained: Explained,
    /// Where the model with them has the tip, three numbers a sample, metres.
    pub(crate) played: Vec<f64>,
    /// Change of the tip over each coordinate in units of its probe.
    pub(crate) jacobian: DMatrix<f64>,
}

impl Fitted {
    /// Whether the hypothesis of this number is a member.
    pub(crate) fn has(&self, hypothesis: usize) -> bool {
        self.members.iter().any(|member| member.hypothesis == hypothesis)
    }
}

/// Steps of a fit at most.
const MOST_STEPS: usize = 12;
/// A fall of the deviance that is not worth another step.
const SMALL_FALL: f64 = 0.05;
/// The same where the best is not yet asked for.
const ROUGH_FALL: f64 = 2.0;
/// And this share of what is missing to a deviance that would be of use: so slow a fit is not going to be.
const SLOW_FALL: f64 = 0.1;
/// Makes a coordinate so much stiffer that it stays where it is put.
const HOLDS: f64 = 1e12;
/// A step that is cut by this share was to leave a range.
const BEYOND: f64 = 1e-6;
/// Size of the differences that derivatives are taken by, over the probe.
const DIFFERENCE: f64 = 0.1;

/// How well a fit is to be known.
#[derive(Clone, Copy)]
enum Precision {
    /// Until steps bring little; a deviance above `wanted` is of no use.
    Rough { wanted: f64 },
    /// As well as can be by the derivative that is known, where that brings the deviance below `wanted`.
    Near { wanted: f64 },
    /// As well as can be, with derivatives taken anew before it ends; `fresh`: they are at the start.
    Exact { fresh: bool },
}

impl Study<'_> {
    /// The model as it is, without any hypothesis.
    pub(crate) fn null(&self) -> Option<Fitted> {
        self.at(Vec::new())
    }

    /// The same members as this model plays them, with the derivative that is known.
    pub(crate) fn again(&self, fitted: &Fitted) -> Option<Fitted> {
        Some(Fitted { jacobian: fitted.jacobian.clone(), ..self.at(fitted.members.clone())? })
    }

    /// The best values of all of `start` together, from there; none where the model cannot play them.
    pub(crate) fn fit(&self, start: Vec<Member>) -> Option<Fitted> {
        let start = self.at(start)?;
        let start = self.sharpened(start)?;
        self.descend(start, Precision::Exact { fresh: true })
    }

    /// The same from near them, by a derivative that is known roughly (in units of the probes; zero holds a coordinate
    /// until derivatives are taken anew).
    pub(crate) fn refit(&self, start: Vec<Member>, jacobian: DMatrix<f64>) -> Option<Fitted> {
        self.descend(Fitted { jacobian, ..self.at(start)? }, Precision::Exact { fresh: false })
    }

    /// Nearly the best values from `start`, by a derivative that is known roughly (in units of the probes; zero holds a
    /// coordinate). A fit whose deviance falls too slowly to come below `wanted` ends sooner.
    pub(crate) fn rough_fit(&self, start: Fitted, jacobian: DMatrix<f64>, wanted: f64) -> Option<Fitted> {
        self.descend(Fitted { jacobian, ..start }, Precision::Rough { wanted })
    }

    /// The members moved by `step` (in units of the probes), every coordinate no farther than its range reaches, and how far
    /// coordinate `at` was.
    pub(crate) fn along(&self, members: &[Member], at: usize, step: &DVector<f64>) -> (Vec<Member>, f64) {
        let there = self.moved(members, step);
        let moved = self.between(members, &there)[at];
        (there, moved)
    }

    /// The fit moved to `members`, coordinate `at` held there and the others fitted, as far as that promises a deviance below
    /// `wanted`.
    pub(crate) fn held(&self, fitted: &Fitted, at: usize, members: Vec<Member>, wanted: f64) -> Option<Fitted> {
        let mut jacobian = fitted.jacobian.clone();
        jacobian.column_mut(at).fill(0.0);
        self.descend(Fitted { jacobian, ..self.at(members)? }, Precision::Near { wanted })
    }

    /// Steps as long as they help.
    fn descend(&self, mut best: Fitted, precision: Precision) -> Option<Fitted> {
        let (exact, mut fresh) = match precision {
            Precision::Rough { .. } | Precision::Near { .. } => (false, true),
            Precision::Exact { fresh } => (true, fresh),
        };
        for _ in 0..MOST_STEPS {
            let small = match precision {
                Precision::Rough { wanted } => ROUGH_FALL.max(SLOW_FALL * (best.explained.deviance - wanted)),
                Precision::Near { .. } | Precision::Exact { .. } => SMALL_FALL,
            };
            let needed = match precision {
                Precision::Near { wanted } => small.max(best.explained.deviance - wanted),
                Precision::Rough { .. } | Precision::Exact { .. } => small,
            };
            let (step, promised) = self.step(&best)?;
            // What promises nothing is not played.
            let shares: &[f64] = if promised < needed { &[] } else { &[1.0, 0.4, 0.1] };
            let next = shares.iter().find_map(|&share| self.improved(&best, &(share * &step)));
            let fall = next.as_ref().map_or(0.0, |next| best.explained.deviance - next.explained.deviance);
            best = next.unwrap_or(best);
            if !exact && fall < small {
                break;
            }
            if fall >= small {
                fresh = false;
            } else if fresh {
                break;
            } else {
                // At the edge of what the model can play the fit ends with the derivative that it has.
                let Some(sharp) = self.sharpened(best.clone()) else { break };
                best = sharp;
                fresh = true;
            }
        }
        Some(best)
    }

    /// The fit with a derivative taken where it ended.
    pub(crate) fn sharpened(&self, mut fitted: Fitted) -> Option<Fitted> {
        fitted.jacobian = self.derivative(&fitted)?;
        Some(fitted)
    }

    /// The coordinates of a fit: member and parameter.
    pub(crate) fn coordinates(&self, members: &[Member]) -> Vec<(usize, usize)> {
        let of = |(k, member): (usize, &Member)| {
            self.hypotheses[member.hypothesis].fitted().into_iter().map(move |parameter| (k, parameter)).collect()
        };
        members.iter().enumerate().flat_map(|entry| -> Vec<(usize, usize)> { of(entry) }).collect()
    }

    /// The derivative of a fit without the coordinates of member number `out`.
    pub(crate) fn slopes_without(&self, fitted: &Fitted, out: usize) -> DMatrix<f64> {
        let coordinates = self.coordinates(&fitted.members);
        let gone: Vec<usize> = (0..coordinates.len()).filter(|&k| coordinates[k].0 == out).collect();
        fitted.jacobian.clone().remove_columns_at(&gone)
    }

    /// A fit without member number `out`, the others as they are.
    pub(crate) fn without(&self, fitted: &Fitted, out: usize) -> Option<Fitted> {
        let mut rest = fitted.members.clone();
        rest.remove(out);
        Some(Fitted { jacobian: self.slopes_without(fitted, out), ..self.at(rest)? })
    }

    /// Covariance of the coordinates, in units of their probes, nuisances integrated out.
    pub(crate) fn covariance(&self, fitted: &Fitted) -> Option<DMatrix<f64>> {
        let (normal, free) = self.normal(fitted);
        let inverse = Cholesky::new(normal)?.inverse();
        let count = inverse.ncols() - free;
        Some(inverse.view((free, free), (count, count)).into_owned())
    }

    /// Inverse of the covariance that a fit leaves of the nuisances, coordinates integrated out.
    pub(crate) fn nuisance_precision(&self, fitted: &Fitted) -> Option<DMatrix<f64>> {
        let (normal, free) = self.normal(fitted);
        let count = normal.ncols() - free;
        let shared = normal.view((0, free), (free, count)).into_owned();
        let own = Cholesky::new(normal.view((free, free), (count, count)).into_owned())?;
        Some(normal.view((0, 0), (free, free)) - &shared * own.solve(&shared.transpose()))
    }

    /// The members with the values that they have, not fitted; none where the model cannot play them.
    pub(crate) fn at(&self, members: Vec<Member>) -> Option<Fitted> {
        let played = tips(self.model, &effects(self.hypotheses, &members)?, self.samples)?;
        let explained = self.explained(&members, &played);
        let jacobian = DMatrix::zeros(played.len(), 0);
        Some(Fitted { members, explained, played, jacobian })
    }

    /// What nuisances and noise make of what the members leave, which have the tip at `played`.
    pub(crate) fn explained(&self, members: &[Member], played: &[f64]) -> Explained {
        let freedom = self.coordinates(members).len() as f64;
        self.nuisances.explain(self.samples, &self.samples.residual(played), freedom)
    }

    /// The members moved by `by`, in units of the probes, every coordinate no farther than its range reaches.
    pub(crate) fn moved(&self, members: &[Member], by: &DVector<f64>) -> Vec<Member> {
        let mut there = members.to_vec();
        for (&(k, parameter), &share) in self.coordinates(members).iter().zip(by.iter()) {
            let hypothesis = &self.hypotheses[members[k].hypothesis];
            there[k].values = hypothesis.moved_within(&there[k].values, parameter, share * hypothesis.probe(parameter));
        }
        there
    }

    /// The step from one set of values to another, in units of the probes.
    fn between(&self, here: &[Member], there: &[Member]) -> DVector<f64> {
        let steps = self.coordinates(here).into_iter().map(|(k, parameter)| {
            let hypothesis = &self.hypotheses[here[k].hypothesis];
            hypothesis.step(&here[k].values, &there[k].values, parameter) / hypothesis.probe(parameter)
        });
        DVector::from_vec(steps.collect())
    }

    /// The fit a step further if that is better, its derivative corrected by what the step has shown (Broyden's
    /// update; Nocedal & Wright, Numerical Optimization, section 11.1).
    fn improved(&self, from: &Fitted, step: &DVector<f64>) -> Option<Fitted> {
        let mut next = self.at(self.moved(&from.members, step))?;
        let step = &self.between(&from.members, &next.members);
        if next.explained.deviance >= from.explained.deviance {
            return None;
        }
        let change = DVector::from_iterator(
            next.played.len(),
            next.played.iter().zip(&from.played).map(|(there, here)| there - here),
        );
        let missed = change - &from.jacobian * step;
        next.jacobian = &from.jacobian + missed * step.transpose() / step.norm_squared().max(f64::MIN_POSITIVE);
        Some(next)
    }

    /// Derivatives by differences of whole recordings, to the side where there is one.
    pub(crate) fn derivative(&self, fitted: &Fitted) -> Option<DMatrix<f64>> {
        let count = self.coordinates(&fitted.members).len();
        let columns: Vec<DVector<f64>> =
            (0..count).into_par_iter().map(|k| self.slope(fitted, k)).collect::<Option<_>>()?;
        Some(DMatrix::from_fn(fitted.played.len(), count, |row, k| columns[k][row]))
    }

    /// The derivative over one coordinate.
    pub(crate) fn slope(&self, fitted: &Fitted, at: usize) -> Option<DVector<f64>> {
        let count = self.coordinates(&fitted.members).len();
        [DIFFERENCE, -DIFFERENCE].into_iter().find_map(|share| {
            let mut by = DVector::zeros(count);
            by[at] = share;
            let (members, moved) = self.along(&fitted.members, at, &by);
            // The end of the range is near on this side.
            if moved.abs() < 0.5 * DIFFERENCE {
                return None;
            }
            let there = tips(self.model, &effects(self.hypotheses, &members)?, self.samples)?;
            Some((DVector::from_vec(there) - DVector::from_column_slice(&fitted.played)) / moved)
        })
    }

    /// Information on nuisances (first) and coordinates, and how many nuisances there are.
    fn normal(&self, fitted: &Fitted) -> (DMatrix<f64>, usize) {
        let noise = &fitted.explained.noise;
        let white = noise.whitened(self.samples, &self.nuisances.with(&fitted.jacobian));
        (self.nuisances.information(&white), self.nuisances.columns.ncols())
    }

    /// The Gauss–Newton step of the coordinates, nuisances following, and by how much it makes the deviance fall if the
    /// tip follows it linearly; coordinates that would leave their range end there, and the others follow them.
    fn step(&self, fitted: &Fitted) -> Option<(DVector<f64>, f64)> {
        let mut ended: Vec<(usize, f64)> = Vec::new();
        loop {
            let (step, promised) = self.step_with(fitted, &ended)?;
            let known = ended.len();
            let moved = self.between(&fitted.members, &self.moved(&fitted.members, &step));
            let is_cut = |k: &usize| (moved[*k] - step[*k]).abs() > BEYOND * step[*k].abs();
            let cut = (0..step.len()).filter(|k| is_cut(k) && !ended.iter().any(|(end, _)| end == k));
            let cut: Vec<(usize, f64)> = cut.map(|k| (k, moved[k])).collect();
            ended.extend(cut);
            if ended.len() == known {
                return Some((step, promised));
            }
        }
    }

    /// The same with the steps of some coordinates `given`.
    fn step_with(&self, fitted: &Fitted, given: &[(usize, f64)]) -> Option<(DVector<f64>, f64)> {
        let (mut normal, free) = self.normal(fitted);
        let count = normal.ncols() - free;
        for k in free..free + count {
            normal[(k, k)] *= 1.0 + 1e-6;
            normal[(k, k)] += 1e-12;
        }
        let noise = &fitted.explained.noise;
        let left = DVector::from_vec(noise.whiten(self.samples, &fitted.explained.left_m));
        let mut right = DVector::zeros(free + count);
        for (k, column) in fitted.jacobian.column_iter().enumerate() {
            right[free + k] = DVector::from_vec(noise.whiten(self.samples, column.as_slice())).dot(&left);
        }
        let (mut stiff, mut pulled) = (normal.clone(), right.clone());
        for &(k, step) in given {
            stiff[(free + k, free + k)] *= HOLDS;
            pulled[free + k] = stiff[(free + k, free + k)] * step;
        }
        let step = Cholesky::new(stiff)?.solve(&pulled);
        let promised = 2.0 * right.dot(&step) - step.dot(&(&normal * &step));
        Some((step.rows(free, count).into_owned(), promised))
    }
}
