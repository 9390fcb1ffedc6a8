//! Gauss–Newton fit of one candidate set with the full physics, together with nuisance parameters
//! and noise.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use crate::base::counted;

use super::candidate::{CandidateEffect, SetMember, effect_specs};
use super::nuisance::{NuisanceFit, Nuisances};
use super::simulate::tips;
use crate::discovery::recording::samples::Samples;
use crate::effects::Model;

/// The data and model that candidate sets are fitted to.
#[derive(Clone)]
pub(crate) struct FitProblem<'a> {
    pub(crate) model: &'a Model,
    /// The model at coarse resolution, for rough fits.
    pub(crate) coarse: &'a Model,
    pub(crate) candidates: &'a [CandidateEffect],
    /// Which candidates may be named.
    pub(crate) open: Vec<bool>,
    pub(crate) samples: &'a Samples,
    pub(crate) nuisances: &'a Nuisances,
}

/// A candidate set with its best-fitting values.
#[derive(Clone, Debug)]
pub(crate) struct FittedSet {
    pub(crate) members: Vec<SetMember>,
    /// Fit of the residual by nuisance parameters and noise.
    pub(crate) nuisance_fit: NuisanceFit,
    /// Simulated tip with the members, three values a sample, metres.
    pub(crate) simulated_m: Vec<f64>,
    /// Tip change over each coordinate, in units of its probe.
    pub(crate) jacobian: DMatrix<f64>,
}

impl FittedSet {
    /// Whether this candidate is a member.
    pub(crate) fn has(&self, candidate: usize) -> bool {
        self.members.iter().any(|member| member.candidate == candidate)
    }
}

/// Maximum number of steps.
const MAX_STEPS: usize = 12;
/// Decrease of the deviance below which an exact fit stops.
const MIN_DECREASE: f64 = 0.05;
/// The same for a rough fit.
const MIN_ROUGH_DECREASE: f64 = 2.0;
/// A rough fit stops as well below this share of the missing decrease.
const MIN_DECREASE_SHARE: f64 = 0.1;
/// Stiffness factor that holds a coordinate.
const HOLDING_STIFFNESS: f64 = 1e12;
/// Relative change that shows that a step was cut at the end of a range.
const CUT_TOLERANCE: f64 = 1e-6;
/// Difference step of numerical derivatives, over the probe.
const DIFFERENCE: f64 = 0.1;

/// A step that ends at the end of the range of its coordinate.
struct HeldStep {
    coordinate: usize,
    step: f64,
}

/// When a fit stops.
#[derive(Clone, Copy)]
enum StopRule {
    /// Stops when steps bring little; a deviance above `target_deviance` is of no use.
    Rough { target_deviance: f64 },
    /// Uses the given Jacobian, as long as a deviance below `target_deviance` is possible.
    Near { target_deviance: f64 },
    /// Converges with a fresh Jacobian; `fresh`: the given one is fresh.
    Exact { fresh: bool },
}

impl FitProblem<'_> {
    /// The given model without any candidate.
    pub(crate) fn evaluate_null(&self) -> Option<FittedSet> {
        self.evaluate(Vec::new())
    }

    /// The same members simulated by this model, with the given Jacobian.
    pub(crate) fn resimulate(&self, fitted: &FittedSet) -> Option<FittedSet> {
        Some(FittedSet {
            jacobian: fitted.jacobian.clone(),
            ..self.evaluate(fitted.members.clone())?
        })
    }

    /// Fits all members of `start` together; none if they cannot be simulated.
    pub(crate) fn fit(&self, start: Vec<SetMember>) -> Option<FittedSet> {
        let start = self.evaluate(start)?;
        let start = self.with_fresh_jacobian(start)?;
        self.descend(start, StopRule::Exact { fresh: true })
    }

    /// The same with an approximate initial Jacobian (in units of the probes; a zero column holds
    /// its coordinate until the Jacobian is renewed).
    pub(crate) fn refit(&self, start: Vec<SetMember>, jacobian: DMatrix<f64>) -> Option<FittedSet> {
        self.descend(
            FittedSet { jacobian, ..self.evaluate(start)? },
            StopRule::Exact { fresh: false },
        )
    }

    /// Rough fit with an approximate Jacobian (in units of the probes; a zero column holds its
    /// coordinate). Stops early if the deviance decreases too slowly to reach `target_deviance`.
    pub(crate) fn rough_fit(
        &self,
        start: FittedSet,
        jacobian: DMatrix<f64>,
        target_deviance: f64,
    ) -> Option<FittedSet> {
        self.descend(FittedSet { jacobian, ..start }, StopRule::Rough { target_deviance })
    }

    /// The members moved by `step` (in units of the probes) within their valid ranges, and the
    /// distance that coordinate `at` moved.
    pub(crate) fn step_along(
        &self,
        members: &[SetMember],
        at: usize,
        step: &DVector<f64>,
    ) -> (Vec<SetMember>, f64) {
        let there = self.moved(members, step);
        let moved = self.between(members, &there)[at];
        (there, moved)
    }

    /// Fits the other coordinates with coordinate `at` held at its value in `members`, as long as a
    /// deviance below `target_deviance` is possible.
    pub(crate) fn fit_holding(
        &self,
        fitted: &FittedSet,
        at: usize,
        members: Vec<SetMember>,
        target_deviance: f64,
    ) -> Option<FittedSet> {
        let mut jacobian = fitted.jacobian.clone();
        // A coordinate without a derivative gets no step.
        jacobian.column_mut(at).fill(0.0);
        self.descend(
            FittedSet { jacobian, ..self.evaluate(members)? },
            StopRule::Near { target_deviance },
        )
    }

    /// Takes steps as long as they help.
    fn descend(&self, mut best: FittedSet, rule: StopRule) -> Option<FittedSet> {
        let (exact, mut fresh) = match rule {
            StopRule::Rough { .. } | StopRule::Near { .. } => (false, true),
            StopRule::Exact { fresh } => (true, fresh),
        };
        for _ in 0..MAX_STEPS {
            // Far from its target a rough fit must make progress in proportion.
            let small = match rule {
                StopRule::Rough { target_deviance } => MIN_ROUGH_DECREASE
                    .max(MIN_DECREASE_SHARE * (best.nuisance_fit.deviance - target_deviance)),
                StopRule::Near { .. } | StopRule::Exact { .. } => MIN_DECREASE,
            };
            // A step that cannot reach the target is not worth a simulation.
            let needed = match rule {
                StopRule::Near { target_deviance } => {
                    small.max(best.nuisance_fit.deviance - target_deviance)
                }
                StopRule::Rough { .. } | StopRule::Exact { .. } => small,
            };
            let (step, predicted) = self.step(&best)?;
            // Steps with too small a predicted decrease are not simulated. Three lengths in place
            // of Marquardt's damping: where none helps, the Jacobian is renewed.
            let shares: &[f64] = if predicted < needed { &[] } else { &[1.0, 0.4, 0.1] };
            let next = shares.iter().find_map(|&share| self.accept_step(&best, &(share * &step)));
            let decrease = next
                .as_ref()
                .map_or(0.0, |next| best.nuisance_fit.deviance - next.nuisance_fit.deviance);
            best = next.unwrap_or(best);
            // A rough fit never renews its Jacobian.
            if !exact && decrease < small {
                break;
            }
            if decrease >= small {
                fresh = false;
            // A fresh Jacobian that gives no progress is at the optimum.
            } else if fresh {
                break;
            } else {
                // At the edge of what can be simulated the fit ends with the old Jacobian.
                let Some(sharp) = self.with_fresh_jacobian(best.clone()) else { break };
                best = sharp;
                fresh = true;
            }
        }
        Some(best)
    }

    /// The fit with a Jacobian at its values.
    pub(crate) fn with_fresh_jacobian(&self, mut fitted: FittedSet) -> Option<FittedSet> {
        fitted.jacobian = self.differentiate(&fitted)?;
        Some(fitted)
    }

    /// The coordinates of a fit: member index and parameter index.
    pub(crate) fn coordinates(&self, members: &[SetMember]) -> Vec<(usize, usize)> {
        let of = |(k, member): (usize, &SetMember)| {
            self.candidates[member.candidate]
                .fitted()
                .into_iter()
                .map(move |parameter| (k, parameter))
                .collect()
        };
        members.iter().enumerate().flat_map(|entry| -> Vec<(usize, usize)> { of(entry) }).collect()
    }

    /// The Jacobian without the coordinates of member `out`.
    pub(crate) fn jacobian_without(&self, fitted: &FittedSet, out: usize) -> DMatrix<f64> {
        let coordinates = self.coordinates(&fitted.members);
        let removed: Vec<usize> =
            (0..coordinates.len()).filter(|&k| coordinates[k].0 == out).collect();
        fitted.jacobian.clone().remove_columns_at(&removed)
    }

    /// The fit without member `out`, the others unchanged.
    pub(crate) fn evaluate_without(&self, fitted: &FittedSet, out: usize) -> Option<FittedSet> {
        let mut rest = fitted.members.clone();
        rest.remove(out);
        Some(FittedSet { jacobian: self.jacobian_without(fitted, out), ..self.evaluate(rest)? })
    }

    /// Covariance of the coordinates, in units of their probes, nuisance parameters integrated out.
    pub(crate) fn covariance(&self, fitted: &FittedSet) -> Option<DMatrix<f64>> {
        let (normal, free) = self.normal_matrix(fitted);
        let inverse = Cholesky::new(normal)?.inverse();
        let count = inverse.ncols() - free;
        // A block of the inverse is the covariance with all other parameters integrated out.
        Some(inverse.view((free, free), (count, count)).into_owned())
    }

    /// Posterior precision of the nuisance parameters, coordinates integrated out.
    pub(crate) fn nuisance_precision(&self, fitted: &FittedSet) -> Option<DMatrix<f64>> {
        let (normal, free) = self.normal_matrix(fitted);
        let count = normal.ncols() - free;
        let shared = normal.view((0, free), (free, count)).into_owned();
        let factor = Cholesky::new(normal.view((free, free), (count, count)).into_owned())?;
        // Schur complement: the information that is left once the coordinates are fitted, too.
        Some(normal.view((0, 0), (free, free)) - &shared * factor.solve(&shared.transpose()))
    }

    /// Simulates the members with their values; none if the simulation fails.
    pub(crate) fn evaluate(&self, members: Vec<SetMember>) -> Option<FittedSet> {
        let simulated_m =
            tips(self.model, &effect_specs(self.candidates, &members)?, self.samples)?;
        let nuisance_fit = self.fit_nuisances(&members, &simulated_m);
        let jacobian = DMatrix::zeros(simulated_m.len(), 0);
        Some(FittedSet { members, nuisance_fit, simulated_m, jacobian })
    }

    /// Fits nuisance parameters and noise to the residual of the members; `simulated_m`: their
    /// simulated tip.
    pub(crate) fn fit_nuisances(&self, members: &[SetMember], simulated_m: &[f64]) -> NuisanceFit {
        let freedom = self.coordinates(members).len() as f64;
        self.nuisances.explain(self.samples, &self.samples.residual(simulated_m), freedom)
    }

    /// The members moved by `by`, in units of the probes, within their valid ranges.
    pub(crate) fn moved(&self, members: &[SetMember], by: &DVector<f64>) -> Vec<SetMember> {
        let mut there = members.to_vec();
        for (&(k, parameter), &share) in self.coordinates(members).iter().zip(by.iter()) {
            let candidate = &self.candidates[members[k].candidate];
            there[k].values = candidate.moved_within(
                &there[k].values,
                parameter,
                share * candidate.probe(parameter),
            );
        }
        there
    }

    /// The step between two sets of values, in units of the probes.
    fn between(&self, here: &[SetMember], there: &[SetMember]) -> DVector<f64> {
        let steps = self.coordinates(here).into_iter().map(|(k, parameter)| {
            let candidate = &self.candidates[here[k].candidate];
            candidate.step(&here[k].values, &there[k].values, parameter)
                / candidate.probe(parameter)
        });
        DVector::from_vec(steps.collect())
    }

    /// The fit after a step if that is better, with Broyden's update of the Jacobian (Nocedal &
    /// Wright, Numerical Optimization, section 11.1).
    fn accept_step(&self, from: &FittedSet, step: &DVector<f64>) -> Option<FittedSet> {
        let mut next = self.evaluate(self.moved(&from.members, step))?;
        // The range may have cut the step; Broyden's update needs the step that was made.
        let step = &self.between(&from.members, &next.members);
        if next.nuisance_fit.deviance >= from.nuisance_fit.deviance {
            return None;
        }
        let change = DVector::from_iterator(
            next.simulated_m.len(),
            next.simulated_m.iter().zip(&from.simulated_m).map(|(there, here)| there - here),
        );
        // Broyden: the least change of the Jacobian that reproduces this step.
        let missed = change - &from.jacobian * step;
        next.jacobian =
            &from.jacobian + missed * step.transpose() / step.norm_squared().max(f64::MIN_POSITIVE);
        Some(next)
    }

    /// Numerical Jacobian by one-sided differences of whole simulations.
    pub(crate) fn differentiate(&self, fitted: &FittedSet) -> Option<DMatrix<f64>> {
        let count = self.coordinates(&fitted.members).len();
        let columns: Vec<DVector<f64>> =
            // Columns are independent simulations.
            (0..count).into_par_iter().map(counted(|k| self.jacobian_column(fitted, k))).collect::<Option<_>>()?;
        Some(DMatrix::from_fn(fitted.simulated_m.len(), count, |row, k| columns[k][row]))
    }

    /// Jacobian column of one coordinate.
    pub(crate) fn jacobian_column(&self, fitted: &FittedSet, at: usize) -> Option<DVector<f64>> {
        let count = self.coordinates(&fitted.members).len();
        [DIFFERENCE, -DIFFERENCE].into_iter().find_map(|share| {
            let mut by = DVector::zeros(count);
            by[at] = share;
            let (members, moved) = self.step_along(&fitted.members, at, &by);
            // The end of the range is near on this side.
            if moved.abs() < 0.5 * DIFFERENCE {
                return None;
            }
            let there = tips(self.model, &effect_specs(self.candidates, &members)?, self.samples)?;
            Some(
                (DVector::from_vec(there) - DVector::from_column_slice(&fitted.simulated_m))
                    / moved,
            )
        })
    }

    /// Normal matrix of nuisance parameters (first) and coordinates, and the number of nuisance
    /// parameters.
    fn normal_matrix(&self, fitted: &FittedSet) -> (DMatrix<f64>, usize) {
        let noise = &fitted.nuisance_fit.noise;
        let white = noise.whitened(self.samples, &self.nuisances.with(&fitted.jacobian));
        (self.nuisances.information(&white), self.nuisances.columns.ncols())
    }

    /// The Gauss–Newton step and the predicted decrease of the deviance. Coordinates that would
    /// leave their range stop at its end, and the others follow.
    fn step(&self, fitted: &FittedSet) -> Option<(DVector<f64>, f64)> {
        let mut held: Vec<HeldStep> = Vec::new();
        loop {
            let (step, predicted) = self.constrained_step(fitted, &held)?;
            let moved = self.between(&fitted.members, &self.moved(&fitted.members, &step));
            // Active set: a coordinate that meets its bound is fixed there and the rest is solved
            // anew.
            let is_cut = |k: &usize| (moved[*k] - step[*k]).abs() > CUT_TOLERANCE * step[*k].abs();
            let cut = (0..step.len())
                .filter(|k| is_cut(k) && !held.iter().any(|held| held.coordinate == *k));
            let cut: Vec<HeldStep> =
                cut.map(|k| HeldStep { coordinate: k, step: moved[k] }).collect();
            if cut.is_empty() {
                return Some((step, predicted));
            }
            // Each pass holds one more coordinate at least, so the loop ends.
            held.extend(cut);
        }
    }

    /// The same with these steps of some coordinates.
    fn constrained_step(
        &self,
        fitted: &FittedSet,
        held: &[HeldStep],
    ) -> Option<(DVector<f64>, f64)> {
        let (mut normal, free) = self.normal_matrix(fitted);
        let count = normal.ncols() - free;
        for k in free..free + count {
            // A tiny Levenberg term keeps collinear or held (zero) columns solvable.
            normal[(k, k)] *= 1.0 + 1e-6;
            normal[(k, k)] += 1e-12;
        }
        let noise = &fitted.nuisance_fit.noise;
        let residual =
            DVector::from_vec(noise.whiten(self.samples, &fitted.nuisance_fit.residual_m));
        // Nuisance parameters are at their optimum for this residual, so their gradient is zero.
        let mut right = DVector::zeros(free + count);
        for (k, column) in fitted.jacobian.column_iter().enumerate() {
            right[free + k] =
                DVector::from_vec(noise.whiten(self.samples, column.as_slice())).dot(&residual);
        }
        let (mut stiff, mut pulled) = (normal.clone(), right.clone());
        for &HeldStep { coordinate: k, step } in held {
            // Penalty: a huge stiffness with its load fixes the step at the wanted value.
            stiff[(free + k, free + k)] *= HOLDING_STIFFNESS;
            pulled[free + k] = stiff[(free + k, free + k)] * step;
        }
        let step = Cholesky::new(stiff)?.solve(&pulled);
        // Decrease of the quadratic model 2 gᵀs − sᵀHs, without the penalty.
        let predicted = 2.0 * right.dot(&step) - step.dot(&(&normal * &step));
        Some((step.rows(free, count).into_owned(), predicted))
    }
}
