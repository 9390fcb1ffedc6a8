//! The oracle: noise-free residual of a tip displacement after imitation by the best small set of effects of the
//! catalogue. It decides in advance whether an injected effect is outside or inside the span of the catalogue.

pub(crate) mod imitations;
pub(crate) mod metric;
pub(crate) mod refit;

use nalgebra::{Cholesky, DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::commands::Commands;
use super::error::BenchmarkError;
use super::injection::injected_effects::{card, drawn_catalogue, null_value, size};
use super::options::{OracleOptions, Prior};
use super::truth::is_component_of;
use crate::effects::{Card, EffectSpec, Model, Seek};
use metric::Metric;
use refit::{Members, Refit, difference};

/// Number of positions along the robot.
const PLACES: usize = 11;
/// Number of refitted sets.
const REFITTED: usize = 2;

/// Sensitivities of the tip to all effects of the catalogue under one set of commands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CatalogueSpan {
    /// Unit of all sizes: noise by axis, metres.
    noise_m: f64,
    /// Tip change over the noise by one standard deviation of each uncertain parameter.
    uncertain: Vec<Vec<f64>>,
    pub(crate) responses: Vec<EffectResponse>,
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
        let here = commands.tips_m(model, &[]).ok_or(BenchmarkError::Unplayable)?;
        let respond = |card: &'static Card, null: &[f64], parameter: usize, step: f64| -> Option<Vec<f64>> {
            // If one direction cannot be simulated, the other may.
            [step, -step].into_iter().find_map(|step| {
                let mut values = null.to_vec();
                values[parameter] += step;
                let there = commands.tips_m(model, &[EffectSpec::from_card(card, &values)?])?;
                let sign = step.signum() / noise_m;
                Some(difference(&there, &here).iter().map(|x| x * sign).collect())
            })
        };
        let mut responses = Vec::new();
        for card in drawn_catalogue() {
            for null in nulls(card, model) {
                let sizes = (0..null.len()).filter_map(|k| Some((k, size(&card.parameters[k])?)));
                let columns: Option<Vec<_>> = sizes.map(|(k, size)| respond(card, &null, k, size.abs())).collect();
                responses.extend(columns.map(|columns| EffectResponse { name: card.name.to_owned(), null, columns }));
            }
        }
        let mut span = CatalogueSpan { noise_m, uncertain: Vec::new(), responses };
        span.uncertain = priors.iter().flat_map(|prior| span.prior_responses(prior)).collect();
        Ok(span)
    }

    /// Tip changes by one standard deviation of an uncertain parameter: each component and each tendon.
    fn prior_responses(&self, prior: &Prior) -> Vec<Vec<f64>> {
        let Some(card) = card(&prior.effect) else { return Vec::new() };
        let about_one = card.parameters.iter().any(|parameter| parameter.seek == Seek::Tendon);
        let sizes: Vec<_> = card
            .parameters
            .iter()
            .filter_map(|one| Some((is_component_of(one.name, prior), size(one)?.abs())))
            .collect();
        let own = self.responses.iter().filter(|response| response.name == prior.effect);
        let own = own.take(if about_one { usize::MAX } else { 1 });
        let scaled = |column: &Vec<f64>, size: f64| column.iter().map(|x| x * prior.deviation / size).collect();
        own.flat_map(|response| {
            let meant = response.columns.iter().zip(&sizes).filter(|(_, (meant, _))| *meant);
            meant.map(|(column, (_, size))| scaled(column, *size)).collect::<Vec<Vec<f64>>>()
        })
        .collect()
    }

    /// Residual of `moved` (three values a sample, metres) over the noise after the best linear imitation by at most
    /// `most` effects. `left_out`: excluded effects.
    pub fn first_look(&self, moved: &[f64], left_out: &[String], most: usize) -> f64 {
        let wanted: Vec<f64> = moved.iter().map(|x| x / self.noise_m).collect();
        let metric = Metric::new(&self.uncertain);
        let best = self.sets(&metric, &wanted, left_out, most).into_iter().next();
        rms(best.map_or_else(|| metric.square(&wanted), |set| set.left), wanted.len())
    }

    /// The same with the most promising sets refitted nonlinearly, including shapes.
    pub fn left(
        &self,
        model: &Model,
        commands: &Commands,
        moved: &[f64],
        left_out: &[String],
        options: &OracleOptions,
        outside: bool,
    ) -> f64 {
        let Some(refit) = self.refit(model, commands, moved) else { return f64::INFINITY };
        let (metric, wanted) = (&refit.metric, &refit.wanted);
        let enough = if outside { options.outside_above } else { options.inside_below };
        let mut least = rms(metric.square(wanted), wanted.len());
        let sets = self.sets(metric, wanted, left_out, options.most_effects);
        for set in sets.into_iter().take(REFITTED) {
            least = least.min(rms(refit.remaining_square(self.members(&set)), wanted.len()));
            if least < enough {
                break; // decided: less can only be less
            }
        }
        least
    }

    /// Refits of sets to `moved`; none if the simulation fails.
    pub(crate) fn refit<'a>(&'a self, model: &'a Model, commands: &'a Commands, moved: &[f64]) -> Option<Refit<'a>> {
        Some(Refit {
            model,
            commands,
            here: commands.tips_m(model, &[])?,
            noise_m: self.noise_m,
            metric: Metric::new(&self.uncertain),
            wanted: moved.iter().map(|x| x / self.noise_m).collect(),
        })
    }

    /// Sets of effects with their amounts, smallest residual first.
    pub(crate) fn sets(&self, metric: &Metric, wanted: &[f64], left_out: &[String], most: usize) -> Vec<EffectSet> {
        let open: Vec<usize> =
            (0..self.responses.len()).filter(|&k| !left_out.contains(&self.responses[k].name)).collect();
        let columns: Vec<(usize, &Vec<f64>)> =
            open.iter().flat_map(|&k| self.responses[k].columns.iter().map(move |column| (k, column))).collect();
        let gram = DMatrix::from_fn(columns.len(), columns.len(), |a, b| {
            if a <= b { metric.product(columns[a].1, columns[b].1) } else { 0.0 }
        });
        let along = DVector::from_fn(columns.len(), |k, _| metric.product(columns[k].1, wanted));
        let whole = metric.square(wanted);
        let mut sets = Vec::new();
        each_set(&open, most.min(open.len()), &mut Vec::new(), &mut |chosen| {
            let of: Vec<usize> = (0..columns.len()).filter(|&k| chosen.contains(&columns[k].0)).collect();
            let part = DMatrix::from_fn(of.len(), of.len(), |a, b| {
                let (low, high) = (of[a].min(of[b]), of[a].max(of[b]));
                gram[(low, high)] * if a == b { 1.0 + 1e-9 } else { 1.0 }
            });
            let along = DVector::from_fn(of.len(), |k, _| along[of[k]]);
            if let Some(factor) = Cholesky::new(part) {
                let amounts = factor.solve(&along);
                let left = (whole - amounts.dot(&along)).max(0.0);
                sets.push(EffectSet { responses: chosen.to_vec(), amounts: amounts.as_slice().to_vec(), left });
            }
        });
        sets.sort_by(|a, b| a.left.total_cmp(&b.left));
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
    left: f64,
}

/// Calls `found` with every set of `most` of `open`.
fn each_set(open: &[usize], most: usize, chosen: &mut Vec<usize>, found: &mut dyn FnMut(&[usize])) {
    if chosen.len() == most {
        found(chosen);
        return;
    }
    for (k, &next) in open.iter().enumerate() {
        chosen.push(next);
        each_set(&open[k + 1..], most, chosen, found);
        chosen.pop();
    }
}

pub(crate) fn rms(square: f64, rows: usize) -> f64 {
    (square / rows.max(1) as f64).sqrt()
}

/// Values of an effect without influence: all combinations of shapes, positions and tendons.
fn nulls(card: &Card, model: &Model) -> Vec<Vec<f64>> {
    let length_m = model.robot.backbone.length_m;
    let mut found = vec![Vec::new()];
    for parameter in card.parameters {
        let values: Vec<f64> = match parameter.seek {
            Seek::Size(_) | Seek::Scanned(..) | Seek::Replaces(..) | Seek::Distance(_) | Seek::Located(_) => {
                vec![null_value(parameter, model)]
            }
            Seek::Shape(tries) => tries.to_vec(),
            Seek::Place => (0..PLACES).map(|k| length_m * (k as f64 + 0.5) / PLACES as f64).collect(),
            Seek::Tendon => (1..=model.robot.tendons.angles_deg.len()).map(|tendon| tendon as f64).collect(),
            Seek::Flag => vec![0.0, 1.0],
        };
        let longer = |known: &Vec<f64>| -> Vec<Vec<f64>> {
            values.iter().map(|&value| known.iter().copied().chain([value]).collect()).collect()
        };
        found = found.iter().flat_map(longer).collect();
    }
    found
}
