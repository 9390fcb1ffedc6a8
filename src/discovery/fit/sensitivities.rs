//! How the tip answers to a little of every hypothesis: what a first look at the residual is projected on.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::candidate::{Hypothesis, Member, effects};
use super::simulate::tips;
use crate::discovery::recording::samples::Samples;
use crate::effects::Model;

/// The answers to one variant of a hypothesis.
#[derive(Clone, Debug)]
pub(crate) struct Response {
    /// Number of the hypothesis.
    pub(crate) hypothesis: usize,
    /// Values of the card's parameters at which nothing changes.
    pub(crate) null: Vec<f64>,
    /// Change of the tip over change of the parameter, three numbers a sample, a column a size.
    pub(crate) columns: DMatrix<f64>,
    /// The change of the sizes, one a column, that it holds for; none for small changes.
    pub(crate) step: Option<Vec<f64>>,
}

impl Response {
    /// Whether it is the answer to a little of the same variant.
    pub(crate) fn is_little_of(&self, other: &Response) -> bool {
        self.step.is_none() && self.hypothesis == other.hypothesis && self.null == other.null
    }
}

/// Answers of `model` with the `members` to every variant of those hypotheses that are `asked` about; variants that the
/// model cannot play are left out, and all of them when it cannot play the samples as it is.
pub(crate) fn responses(
    model: &Model,
    hypotheses: &[Hypothesis],
    members: &[Member],
    asked: &(dyn Fn(&Hypothesis) -> bool + Sync),
    samples: &Samples,
) -> Vec<Response> {
    let known = effects(hypotheses, members).unwrap_or_default();
    let Some(played) = tips(model, &known, samples) else { return Vec::new() };
    let played = played.as_slice();
    let variants: Vec<(usize, Vec<f64>)> = hypotheses
        .iter()
        .enumerate()
        .filter(|(_, hypothesis)| asked(hypothesis))
        .flat_map(|(number, hypothesis)| hypothesis.variants().into_iter().map(move |null| (number, null)))
        .collect();
    let answer = |(number, null): (usize, Vec<f64>)| {
        let hypothesis = &hypotheses[number];
        let column = |&size: &usize| -> Option<Vec<f64>> {
            let step = hypothesis.probe(size);
            // Where the one direction cannot be played, the other may.
            [step, -step].into_iter().find_map(|step| {
                let effect = hypothesis.effect(&hypothesis.moved(&null, size, step))?;
                let there = tips(model, &[known.as_slice(), &[effect]].concat(), samples)?;
                Some(there.iter().zip(played).map(|(there, here)| (there - here) / step).collect())
            })
        };
        let columns: Vec<Vec<f64>> = hypothesis.sizes().iter().map(column).collect::<Option<_>>()?;
        let columns = DMatrix::from_fn(played.len(), columns.len(), |row, k| columns[k][row]);
        Some(Response { hypothesis: number, null, columns, step: None })
    };
    variants.into_par_iter().filter_map(answer).collect()
}
