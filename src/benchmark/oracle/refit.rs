//! Noise-free nonlinear refit of a few effects to a tip displacement.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::metric::Metric;
use crate::base::Point3;
use crate::benchmark::commands::Commands;
use crate::benchmark::injection::injected_effects::{null_value, size};
use crate::effects::{Card, EffectSpec, Model, Seek};

/// Maximum number of steps.
const MAX_ROUNDS: usize = 5;
/// Relative progress below which a refit stops.
const MIN_PROGRESS: f64 = 0.03;
/// Maximum number of times that a set is weakened until it can be simulated.
const MAX_WEAKENINGS: usize = 6;
/// Steps of finite differences, in usual sizes or as a share of a shape.
const DIFFERENCE_STEP: f64 = 0.05;
/// Lengths of a Gauss–Newton step that are tried in turn.
const STEP_LENGTHS: [f64; 4] = [1.0, 0.5, 0.2, 0.05];

/// Effects with values.
pub(crate) type Members = Vec<(&'static Card, Vec<f64>)>;

/// Difference of two tip paths, three values a sample.
pub(crate) fn difference(tips_m: &[Point3], from_m: &[Point3]) -> Vec<f64> {
    tips_m
        .iter()
        .zip(from_m)
        .flat_map(|(a, b)| std::array::from_fn::<f64, 3, _>(|axis| a[axis] - b[axis]))
        .collect()
}

/// Refit of a set of effects to a tip displacement: Gauss–Newton steps with step halving. A trial
/// step simulates all commands, so four lengths are tried at most; Marquardt's damping
/// (`math::optimise::least_squares`) would try more.
pub(crate) struct Refit<'a> {
    pub(crate) model: &'a Model,
    pub(crate) commands: &'a Commands,
    /// Tip without any of the effects, metres.
    pub(crate) nominal_m: Vec<Point3>,
    pub(crate) noise_m: f64,
    pub(crate) metric: Metric<'a>,
    /// Displacement over the noise, three values a sample.
    pub(crate) target: Vec<f64>,
}

impl Refit<'_> {
    /// Remaining square over the noise.
    pub(crate) fn remaining_square(&self, mut members: Members) -> f64 {
        let Some(mut residual) = self.weaken_until_playable(&mut members) else {
            return f64::INFINITY;
        };
        let mut square = self.metric.square(&residual);
        for _ in 0..MAX_ROUNDS {
            let Some((next, next_residual)) = self.improve(&members, &residual, square) else {
                break;
            };
            let progress = 1.0 - self.metric.square(&next_residual) / square.max(1e-300);
            (members, residual) = (next, next_residual);
            square = self.metric.square(&residual);
            if progress < MIN_PROGRESS {
                break;
            }
        }
        square
    }

    /// Weakens the members until they can be simulated; returns their residual.
    fn weaken_until_playable(&self, members: &mut Members) -> Option<Vec<f64>> {
        for _ in 0..MAX_WEAKENINGS {
            if let Some(residual) = self.residual(members) {
                return Some(residual);
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
        let effects: Vec<EffectSpec> = members
            .iter()
            .map(|(card, values)| EffectSpec::from_card(card, values))
            .collect::<Option<_>>()?;
        let tips_m = self.commands.tips_m(self.model, &effects)?;
        let displacement_m = difference(&tips_m, &self.nominal_m);
        Some(
            self.target
                .iter()
                .zip(displacement_m)
                .map(|(target, displacement_m)| target - displacement_m / self.noise_m)
                .collect(),
        )
    }

    /// Improved members with their residual; none if no step helps.
    fn improve(
        &self,
        members: &Members,
        residual: &[f64],
        square: f64,
    ) -> Option<(Members, Vec<f64>)> {
        let mut parameters = Vec::new();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (k, (card, values)) in members.iter().enumerate() {
            for (index, parameter) in card.parameters.iter().enumerate() {
                let step = match parameter.seek {
                    Seek::Size(size)
                    | Seek::Scanned(size, _)
                    | Seek::Replaces(_, size)
                    | Seek::Distance(size)
                    | Seek::Located(size) => DIFFERENCE_STEP * size,
                    Seek::Shape(_) => DIFFERENCE_STEP * values[index].abs().max(0.5),
                    Seek::Place | Seek::Tendon | Seek::Segment | Seek::Flag | Seek::Convention => {
                        continue;
                    }
                };
                let column = [step, -step].into_iter().find_map(|step| {
                    let mut moved = members.clone();
                    moved[k].1[index] += step;
                    let moved_residual = self.residual(&moved)?;
                    Some(
                        residual
                            .iter()
                            .zip(moved_residual)
                            .map(|(before, after)| (before - after) / step)
                            .collect(),
                    )
                });
                if let Some(column) = column {
                    parameters.push((k, index));
                    columns.push(column);
                }
            }
        }
        // A small ridge, so that dependent columns can be solved for.
        let gram = DMatrix::from_fn(columns.len(), columns.len(), |a, b| {
            self.metric.product(&columns[a], &columns[b]) * if a == b { 1.0 + 1e-6 } else { 1.0 }
        });
        let gradient =
            DVector::from_fn(columns.len(), |k, _| self.metric.product(&columns[k], residual));
        let step = Cholesky::new(gram)?.solve(&gradient);
        STEP_LENGTHS.into_iter().find_map(|share| {
            let mut moved = members.clone();
            parameters
                .iter()
                .zip(step.iter())
                .for_each(|(&(k, index), step)| moved[k].1[index] += share * step);
            let moved_residual = self.residual(&moved)?;
            (self.metric.square(&moved_residual) < square).then_some((moved, moved_residual))
        })
    }
}
