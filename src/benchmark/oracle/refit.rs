//! Noise-free nonlinear refit of a few effects to a tip displacement.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::metric::Metric;
use crate::base::Point3;
use crate::benchmark::commands::Commands;
use crate::benchmark::injection::injected_effects::{null_value, size};
use crate::effects::{Card, EffectSpec, Model, Seek};

/// Maximum number of steps.
const ROUNDS: usize = 5;
/// Relative progress below which a refit stops.
const PROGRESS: f64 = 0.03;

/// Effects with values.
pub(crate) type Members = Vec<(&'static Card, Vec<f64>)>;

/// Difference of `there` and `here`, three values a sample.
pub(crate) fn difference(there: &[Point3], here: &[Point3]) -> Vec<f64> {
    there.iter().zip(here).flat_map(|(a, b)| std::array::from_fn::<f64, 3, _>(|axis| a[axis] - b[axis])).collect()
}

/// Refit of a set of effects to a tip displacement: Gauss–Newton steps with step halving. A trial step simulates all
/// commands, so four lengths are tried at most; Marquardt's damping (`math::optimise::least_squares`) would try more.
pub(crate) struct Refit<'a> {
    pub(crate) model: &'a Model,
    pub(crate) commands: &'a Commands,
    pub(crate) here: Vec<Point3>,
    pub(crate) noise_m: f64,
    pub(crate) metric: Metric<'a>,
    pub(crate) wanted: Vec<f64>,
}

impl Refit<'_> {
    /// Remaining square over the noise.
    pub(crate) fn remaining_square(&self, mut members: Members) -> f64 {
        let Some(mut rest) = self.weaken_until_playable(&mut members) else { return f64::INFINITY };
        let mut square = self.metric.square(&rest);
        for _ in 0..ROUNDS {
            let Some((next, there)) = self.improve(&members, &rest, square) else { break };
            let progress = 1.0 - self.metric.square(&there) / square.max(1e-300);
            (members, rest) = (next, there);
            square = self.metric.square(&rest);
            if progress < PROGRESS {
                break;
            }
        }
        square
    }

    /// Weakens the members until they can be simulated; returns their residual.
    fn weaken_until_playable(&self, members: &mut Members) -> Option<Vec<f64>> {
        for _ in 0..6 {
            if let Some(rest) = self.residual(members) {
                return Some(rest);
            }
            for (card, values) in members.iter_mut() {
                for (value, parameter) in values.iter_mut().zip(card.parameters) {
                    if size(parameter).is_some() {
                        let null = null_value(parameter, self.model);
                        let weaker = null + 0.5 * (*value - null);
                        *value = weaker;
                    }
                }
                // A size whose sign is not allowed: nearly zero.
                if EffectSpec::from_card(card, values).is_none() {
                    for (value, parameter) in values.iter_mut().zip(card.parameters) {
                        if let Some(size) = size(parameter) {
                            *value = null_value(parameter, self.model) + 0.05 * size;
                        }
                    }
                }
            }
        }
        None
    }

    /// Residual over the noise with these members; none if the simulation fails.
    fn residual(&self, members: &Members) -> Option<Vec<f64>> {
        let effects: Vec<EffectSpec> =
            members.iter().map(|(card, values)| EffectSpec::from_card(card, values)).collect::<Option<_>>()?;
        let there = self.commands.tips_m(self.model, &effects)?;
        let moved = difference(&there, &self.here);
        Some(self.wanted.iter().zip(moved).map(|(wanted, moved)| wanted - moved / self.noise_m).collect())
    }

    /// Improved members with their residual; none if no step helps.
    fn improve(&self, members: &Members, rest: &[f64], square: f64) -> Option<(Members, Vec<f64>)> {
        let mut places = Vec::new();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (k, (card, values)) in members.iter().enumerate() {
            for (index, parameter) in card.parameters.iter().enumerate() {
                let step = match parameter.seek {
                    Seek::Size(size)
                    | Seek::Scanned(size, _)
                    | Seek::Replaces(_, size)
                    | Seek::Distance(size)
                    | Seek::Located(size) => 0.05 * size,
                    Seek::Shape(_) => 0.05 * values[index].abs().max(0.5),
                    Seek::Place | Seek::Tendon | Seek::Flag => continue,
                };
                let column = [step, -step].into_iter().find_map(|step| {
                    let mut there = members.clone();
                    there[k].1[index] += step;
                    let left = self.residual(&there)?;
                    Some(rest.iter().zip(left).map(|(here, there)| (here - there) / step).collect())
                });
                if let Some(column) = column {
                    places.push((k, index));
                    columns.push(column);
                }
            }
        }
        let gram = DMatrix::from_fn(columns.len(), columns.len(), |a, b| {
            self.metric.product(&columns[a], &columns[b]) * if a == b { 1.0 + 1e-6 } else { 1.0 }
        });
        let along = DVector::from_fn(columns.len(), |k, _| self.metric.product(&columns[k], rest));
        let step = Cholesky::new(gram)?.solve(&along);
        [1.0, 0.5, 0.2, 0.05].into_iter().find_map(|share| {
            let mut there = members.clone();
            places.iter().zip(step.iter()).for_each(|(&(k, index), step)| there[k].1[index] += share * step);
            let left = self.residual(&there)?;
            (self.metric.square(&left) < square).then_some((there, left))
        })
    }
}
