//! How the tip answers to a little of every candidate: what a first look at the residual is projected on.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::candidate::{CandidateEffect, SetMember, effect_specs};
use super::simulate::tips;
use crate::discovery::recording::samples::Samples;
use crate::effects::Model;

/// The answers to one variant of a candidate.
#[derive(Clone, Debug)]
pub(crate) struct Sensitivity {
    /// Number of the candidate.
    pub(crate) candidate: usize,
    /// Values of the card's parameters at which nothing changes.
    pub(crate) null: Vec<f64>,
    /// Change of the tip over change of the parameter, three numbers a sample, a column a size.
    pub(crate) columns: DMatrix<f64>,
    /// The change of the sizes, one a column, that it holds for; none for small changes.
    pub(crate) step: Option<Vec<f64>>,
}

impl Sensitivity {
    /// Whether it is the answer to a little of the same variant.
    pub(crate) fn is_small_step_of(&self, other: &Sensitivity) -> bool {
        self.step.is_none() && self.candidate == other.candidate && self.null == other.null
    }
}

/// Answers of `model` with the `members` to every variant of those candidates that are `asked` about; variants that the
/// model cannot play are left out, and all of them when it cannot play the samples as it is.
pub(crate) fn sensitivities(
    model: &Model,
    candidates: &[CandidateEffect],
    members: &[SetMember],
    asked: &(dyn Fn(&CandidateEffect) -> bool + Sync),
    samples: &Samples,
) -> Vec<Sensitivity> {
    let known = effect_specs(candidates, members).unwrap_or_default();
    let Some(simulated_m) = tips(model, &known, samples) else { return Vec::new() };
    let simulated_m = simulated_m.as_slice();
    let variants: Vec<(usize, Vec<f64>)> = candidates
        .iter()
        .enumerate()
        .filter(|(_, candidate)| asked(candidate))
        .flat_map(|(number, candidate)| candidate.variants().into_iter().map(move |null| (number, null)))
        .collect();
    let answer = |(number, null): (usize, Vec<f64>)| {
        let candidate = &candidates[number];
        let column = |&size: &usize| -> Option<Vec<f64>> {
            let step = candidate.probe(size);
            // Where the one direction cannot be simulated_m, the other may.
            [step, -step].into_iter().find_map(|step| {
                let effect = candidate.effect(&candidate.moved(&null, size, step))?;
                let there = tips(model, &[known.as_slice(), &[effect]].concat(), samples)?;
                Some(there.iter().zip(simulated_m).map(|(there, here)| (there - here) / step).collect())
            })
        };
        let columns: Vec<Vec<f64>> = candidate.sizes().iter().map(column).collect::<Option<_>>()?;
        let columns = DMatrix::from_fn(simulated_m.len(), columns.len(), |row, k| columns[k][row]);
        Some(Sensitivity { candidate: number, null, columns, step: None })
    };
    variants.into_par_iter().filter_map(answer).collect()
}
