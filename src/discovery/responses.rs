//! How the tip answers to a little of every hypothesis: what a first look at the residual is projected on.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::hypothesis::Hypothesis;
use super::play::tips;
use super::samples::Samples;
use crate::effects::Model;

/// The answers to one variant of a hypothesis.
#[derive(Clone, Debug)]
pub(super) struct Response {
    /// Number of the hypothesis.
    pub(super) hypothesis: usize,
    /// Values of the card's parameters at which nothing changes.
    pub(super) null: Vec<f64>,
    /// Change of the tip over change of the parameter, three numbers a sample, a column a size.
    pub(super) columns: DMatrix<f64>,
    /// The change of its only size that it holds for; none for small changes.
    pub(super) step: Option<f64>,
}

/// Answers of `model` to every variant of those hypotheses that `asked` names; variants that the model cannot play are
/// left out, and all of them when it cannot play the samples as it is.
pub(super) fn responses(
    model: &Model,
    hypotheses: &[Hypothesis],
    asked: &(dyn Fn(&str) -> bool + Sync),
    samples: &Samples,
) -> Vec<Response> {
    let Some(played) = tips(model, &[], samples) else { return Vec::new() };
    let played = played.as_slice();
    let variants: Vec<(usize, Vec<f64>)> = hypotheses
        .iter()
        .enumerate()
        .filter(|(_, hypothesis)| asked(hypothesis.card.name))
        .flat_map(|(number, hypothesis)| hypothesis.variants().into_iter().map(move |null| (number, null)))
        .collect();
    let answer = |(number, null): (usize, Vec<f64>)| {
        let hypothesis = &hypotheses[number];
        let column = |&size: &usize| -> Option<Vec<f64>> {
            let step = hypothesis.probe(size);
            // Where the one direction cannot be played, the other may.
            [step, -step].into_iter().find_map(|step| {
                let effect = hypothesis.effect(&hypothesis.moved(&null, size, step))?;
                let there = tips(model, &[effect], samples)?;
                Some(there.iter().zip(played).map(|(there, here)| (there - here) / step).collect())
            })
        };
        let columns: Vec<Vec<f64>> = hypothesis.sizes().iter().map(column).collect::<Option<_>>()?;
        let columns = DMatrix::from_fn(played.len(), columns.len(), |row, k| columns[k][row]);
        Some(Response { hypothesis: number, null, columns, step: None })
    };
    variants.into_par_iter().filter_map(answer).collect()
}
