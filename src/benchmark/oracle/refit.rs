//! A few effects fitted to a change of the tip, as far as the tip responses and without noise.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::metric::Metric;
use crate::base::Point3;
use crate::benchmark::commands::Commands;
use crate::benchmark::injection::injected_effects::{null_value, size};
use crate::effects::{Card, EffectSpec, Model, Seek};

/// Rounds of a refit.
const ROUNDS: usize = 5;
/// A round that lowers what is left by a smaller share is the last one.
const PROGRESS: f64 = 0.03;

/// Effects with values.
pub(crate) type Members = Vec<(&'static Card, Vec<f64>)>;

/// By how much `there` is off `here`, three numbers a sample.
pub(crate) fn difference(there: &[Point3], here: &[Point3]) -> Vec<f64> {
    there.iter().zip(here).flat_map(|(a, b)| std::array::from_fn::<f64, 3, _>(|axis| a[axis] - b[axis])).collect()
}

/// A set of effects fitted to a change of the tip: Gauss-Newton steps, halved until they help.
pub(crate) struct Refit<'a> {
    pub(crate) model: &'a Model,
    pub(crate) commands: &'a Commands,
    pub(crate) here: Vec<Point3>,
    pub(crate) noise_m: f64,
    pub(crate) metric: Metric<'a>,
    pub(crate) wanted: Vec<f64>,
}

impl Refit<'_> {
    /// The square of what is left, over the noise.
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

    /// Weakens the members until the model can play them; what they leave.
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
                // A size that has no such sign: as good as nothing of it.
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

    /// What of the wanted change these members leave, over the noise; none where the model cannot play them.
    fn residual(&self, members: &Members) -> Option<Vec<f64>> {
        let effects: Vec<EffectSpec> =
            members.iter().map(|(card, values)| EffectSpec::from_card(card, values)).collect::<Option<_>>()?;
        let there = self.commands.tips_m(self.model, &effects)?;
        let moved = difference(&there, &self.here);
        Some(self.wanted.iter().zip(moved).map(|(wanted, moved)| wanted - moved / self.noise_m).collect())
    }

    /// Better members and what they leave; none when no step helps.
    fn improve(&self, members: &Members, rest: &[f64], square: f64) -> Option<(Members, Vec<f64>)> {
        let mut places = Vec::new();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (k, (card, values)) in members.iter().enumerate() {
            for (index, parameter) in card.parameters.iter().enumerate() {
                let step = match parameter.seek {
                    Seek::Size(size) | Seek::Scanned(size, _) | Seek::Replaces(_, size) => 0.05 * size,
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
