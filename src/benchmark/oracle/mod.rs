//! The oracle: noise-free residual of a tip displacement after imitation by the best small set of
//! effects of the catalogue. It decides in advance whether an injected effect is outside or inside
//! the span of the catalogue.

pub(crate) mod imitations;
pub(crate) mod metric;
pub(crate) mod refit;

use nalgebra::{Cholesky, DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::commands::Commands;
use super::error::BenchmarkError;
use super::injection::injected_effects::{drawn_catalogue, null_value, size};
use super::options::{OracleOptions, Prior};
use super::truth::is_component_of;
use crate::effects::{Card, EffectSpec, Model, Seek, card};
use metric::Metric;
use refit::{Members, Refit, difference};

/// Number of positions along the robot.
const POSITIONS: usize = 11;
/// Number of refitted sets.
const MAX_REFITTED_SETS: usize = 2;

/// Sensitivities of the tip to all effects of the catalogue under one set of commands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CatalogueSpan {
    /// Unit of all sizes: noise by axis, metres.
    noise_m: f64,
    /// Tip change over the noise by one standard deviation of each uncertain parameter.
    uncertain: Vec<Vec<f64>>,
    pub(crate) responses: Vec<EffectResponse>,
}

/// A tip displacement to be imitated.
#[derive(Clone, Copy, Debug)]
pub struct Imitated<'a> {
    /// The model without the injected effect.
    pub model: &'a Model,
    /// The commands.
    pub commands: &'a Commands,
    /// Displacement, three values a sample, metres.
    pub displacement_m: &'a [f64],
    /// Effects that must not take part.
    pub left_out: &'a [String],
    /// Thresholds.
    pub options: &'a OracleOptions,
}

/// Sensitivities to an effect with one combination of shapes, position and tendon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct EffectResponse {
    /// Name of the effect.
    pub(crate) name: String,
    /// Values without influence.
    pub(crate) null: Vec<f64>,
    /// Tip change over the noise by one usual size, one column a size.
    columns: Vec<Vec<f64>>,
}

impl CatalogueSpan {
    /// Computes the sensitivities of `model` under these commands.
    ///
    /// # Errors
    /// [`BenchmarkError::Unplayable`] if the simulation fails.
    pub fn new(
        model: &Model,
        commands: &Commands,
        priors: &[Prior],
        noise_m: f64,
    ) -> Result<CatalogueSpan, BenchmarkError> {
        let nominal_m = commands.tips_m(model, &[]).ok_or(BenchmarkError::Unplayable)?;
        let respond =
            |card: &'static Card, null: &[f64], parameter: usize, step: f64| -> Option<Vec<f64>> {
                // If one direction cannot be simulated, the other may.
                [step, -step].into_iter().find_map(|step| {
                    let mut values = null.to_vec();
                    values[parameter] += step;
                    let tips_m =
                        commands.tips_m(model, &[EffectSpec::from_card(card, &values)?])?;
                    let sign = step.signum() / noise_m;
                    Some(difference(&tips_m, &nominal_m).iter().map(|x| x * sign).collect())
                })
            };
        let mut responses = Vec::new();
        for card in drawn_catalogue() {
            for null in nulls(card, model) {
                let sizes = (0..null.len()).filter_map(|k| Some((k, size(&card.parameters[k])?)));
                let columns: Option<Vec<_>> =
                    sizes.map(|(k, size)| respond(card, &null, k, size.abs())).collect();
                responses.extend(columns.map(|columns| EffectResponse {
                    name: card.name.to_owned(),
                    null,
                    columns,
                }));
            }
        }
        let mut span = CatalogueSpan { noise_m, uncertain: Vec::new(), responses };
        span.uncertain = priors.iter().flat_map(|prior| span.prior_responses(prior)).collect();
        Ok(span)
    }

    /// Tip changes by one standard deviation of an uncertain parameter: each component and each
    /// tendon.
    fn prior_responses(&self, prior: &Prior) -> Vec<Vec<f64>> {
        let Some(card) = card(&prior.effect) else { return Vec::new() };
        let about_one = card.parameters.iter().any(|parameter| parameter.seek == Seek::Tendon);
        let sizes: Vec<_> = card
            .parameters
            .iter()
            .filter_map(|parameter| {
                Some((is_component_of(parameter.name, prior), size(parameter)?.abs()))
            })
            .collect();
        let responses = self.responses.iter().filter(|response| response.name == prior.effect);
        let responses = responses.take(if about_one { usize::MAX } else { 1 });
        let scaled = |column: &Vec<f64>, size: f64| {
            column.iter().map(|x| x * prior.deviation / size).collect()
        };
        responses
            .flat_map(|response| {
                let components = response
                    .columns
                    .iter()
                    .zip(&sizes)
                    .filter(|(_, (is_component, _))| *is_component);
                components
                    .map(|(column, (_, size))| scaled(column, *size))
                    .collect::<Vec<Vec<f64>>>()
            })
            .collect()
    }

    /// Residual of a displacement (three values a sample, metres) over the noise after the best
    /// linear imitation by at most `max_effects` effects. `left_out`: excluded effects.
    pub fn linear_residual(
        &self,
        displacement_m: &[f64],
        left_out: &[String],
        max_effects: usize,
    ) -> f64 {
        let target: Vec<f64> = displacement_m.iter().map(|x| x / self.noise_m).collect();
        let metric = Metric::new(&self.uncertain);
        let best = self.sets(&metric, &target, left_out, max_effects).into_iter().next();
        rms(best.map_or_else(|| metric.square(&target), |set| set.residual_square), target.len())
    }

    /// The same with the most promising sets refitted nonlinearly, including shapes. The refits
    /// stop once the group, outside of the span or not, is decided.
    pub fn residual(&self, imitated: &Imitated, outside: bool) -> f64 {
        let Some(refit) = self.refit(imitated) else { return f64::INFINITY };
        let Imitated { left_out, options, .. } = imitated;
        let (metric, target) = (&refit.metric, &refit.target);
        let threshold = if outside { options.outside_above } else { options.inside_below };
        let mut smallest = rms(metric.square(target), target.len());
        let sets = self.sets(metric, target, left_out, options.most_effects);
        for set in sets.into_iter().take(MAX_REFITTED_SETS) {
            smallest = smallest.min(rms(refit.remaining_square(self.members(&set)), target.len()));
            if smallest < threshold {
                break; // further sets can only leave less
            }
        }
        smallest
    }

    /// Refits of sets to a displacement; none if the simulation fails.
    pub(crate) fn refit<'a>(&'a self, imitated: &Imitated<'a>) -> Option<Refit<'a>> {
        let Imitated { model, commands, displacement_m, .. } = *imitated;
        Some(Refit {
            model,
            commands,
            nominal_m: commands.tips_m(model, &[])?,
            noise_m: self.noise_m,
            metric: Metric::new(&self.uncertain),
            target: displacement_m.iter().map(|x| x / self.noise_m).collect(),
        })
    }

    /// Sets of effects with their amounts, smallest residual first.
    pub(crate) fn sets(
        &self,
        metric: &Metric,
        target: &[f64],
        left_out: &[String],
        max_effects: usize,
    ) -> Vec<EffectSet> {
        let candidates: Vec<usize> = (0..self.responses.len())
            .filter(|&k| !left_out.contains(&self.responses[k].name))
            .collect();
        let columns: Vec<(usize, &Vec<f64>)> = candidates
            .iter()
            .flat_map(|&k| self.responses[k].columns.iter().map(move |column| (k, column)))
            .collect();
        let gram = DMatrix::from_fn(columns.len(), columns.len(), |a, b| {
            if a <= b { metric.product(columns[a].1, columns[b].1) } else { 0.0 }
        });
        // Normal equations of least squares in the metric: all products once, a block of them for
        // each set.
        let projections =
            DVector::from_fn(columns.len(), |k, _| metric.product(columns[k].1, target));
        let target_square = metric.square(target);
        let mut sets = Vec::new();
        each_set(&candidates, max_effects.min(candidates.len()), &mut Vec::new(), &mut |chosen| {
            let indices: Vec<usize> =
                (0..columns.len()).filter(|&k| chosen.contains(&columns[k].0)).collect();
            let block = DMatrix::from_fn(indices.len(), indices.len(), |a, b| {
                let (low, high) = (indices[a].min(indices[b]), indices[a].max(indices[b]));
                gram[(low, high)] * if a == b { 1.0 + 1e-9 } else { 1.0 }
            });
            let projections = DVector::from_fn(indices.len(), |k, _| projections[indices[k]]);
            if let Some(factor) = Cholesky::new(block) {
                let amounts = factor.solve(&projections);
                let residual_square = (target_square - amounts.dot(&projections)).max(0.0);
                sets.push(EffectSet {
                    responses: chosen.to_vec(),
                    amounts: amounts.as_slice().to_vec(),
                    residual_square,
                });
            }
        });
        sets.sort_by(|a, b| a.residual_square.total_cmp(&b.residual_square));
        sets
    }

    /// Effects of a set with their linear amounts.
    pub(crate) fn members(&self, set: &EffectSet) -> Members {
        let mut amounts = set.amounts.iter();
        let member = |&k: &usize| {
            let response = &self.responses[k];
            let card = card(&response.name)?;
            let mut values = response.null.clone();
            for (value, parameter) in values.iter_mut().zip(card.parameters) {
                if let Some(size) = size(parameter) {
                    *value += amounts.next().copied().unwrap_or(0.0) * size.abs();
                }
            }
            Some((card, values))
        };
        set.responses.iter().filter_map(member).collect()
    }
}

/// Indices of sensitivities, amount of each column, and residual square.
pub(crate) struct EffectSet {
    pub(crate) responses: Vec<usize>,
    amounts: Vec<f64>,
    residual_square: f64,
}

/// Calls `visit` with every set of `size` of `candidates`.
fn each_set(
    candidates: &[usize],
    size: usize,
    chosen: &mut Vec<usize>,
    visit: &mut dyn FnMut(&[usize]),
) {
    if chosen.len() == size {
        visit(chosen);
        return;
    }
    for (k, &next) in candidates.iter().enumerate() {
        chosen.push(next);
        each_set(&candidates[k + 1..], size, chosen, visit);
        chosen.pop();
    }
}

pub(crate) fn rms(square: f64, rows: usize) -> f64 {
    (square / rows.max(1) as f64).sqrt()
}

/// Values of an effect without influence: all combinations of shapes, positions and tendons.
fn nulls(card: &Card, model: &Model) -> Vec<Vec<f64>> {
    let length_m = model.robot.backbone.length_m;
    let mut combinations = vec![Vec::new()];
    for parameter in card.parameters {
        let values: Vec<f64> = match parameter.seek {
            Seek::Size(_)
            | Seek::Scanned(..)
            | Seek::Replaces(..)
            | Seek::Distance(_)
            | Seek::Located(_)
            | Seek::Segment
            | Seek::Convention => {
                vec![null_value(parameter, model)]
            }
            Seek::Shape(tries) => tries.to_vec(),
            Seek::Place => {
                (0..POSITIONS).map(|k| length_m * (k as f64 + 0.5) / POSITIONS as f64).collect()
            }
            Seek::Tendon => {
                (1..=model.robot.tendons.angles_deg.len()).map(|tendon| tendon as f64).collect()
            }
            Seek::Flag => vec![0.0, 1.0],
        };
        let extended = |prefix: &Vec<f64>| -> Vec<Vec<f64>> {
            values.iter().map(|&value| prefix.iter().copied().chain([value]).collect()).collect()
        };
        combinations = combinations.iter().flat_map(extended).collect();
    }
    combinations
}
