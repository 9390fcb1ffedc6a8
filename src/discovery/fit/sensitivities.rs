//! Sensitivities: change of the tip with small amounts of every candidate, for the linear
//! screening.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::base::counted;

use super::candidate::{CandidateEffect, SetMember, effect_specs};
use super::simulate::tips;
use crate::discovery::recording::samples::Samples;
use crate::effects::Model;

/// Sensitivity to one variant of a candidate.
#[derive(Clone, Debug)]
pub(crate) struct Sensitivity {
    /// Index of the candidate.
    pub(crate) candidate: usize,
    /// Parameter values without any effect.
    pub(crate) null: Vec<f64>,
    /// Tip change over parameter change, three rows a sample, one column a size.
    pub(crate) columns: DMatrix<f64>,
    /// Step of the sizes for which it holds; none for small steps.
    pub(crate) step: Option<Vec<f64>>,
}

impl Sensitivity {
    /// Whether it is the small-step sensitivity of the same variant.
    pub(crate) fn is_small_step_of(&self, other: &Sensitivity) -> bool {
        self.step.is_none() && self.candidate == other.candidate && self.null == other.null
    }
}

/// Sensitivities of `model` with the `members` to all variants of the candidates that are asked.
/// Variants that cannot be simulated are left out; empty if the model itself cannot be simulated.
pub(crate) fn sensitivities(
    model: &Model,
    candidates: &[CandidateEffect],
    members: &[SetMember],
    is_asked: &(dyn Fn(&CandidateEffect) -> bool + Sync),
    samples: &Samples,
) -> Vec<Sensitivity> {
    let effects = effect_specs(candidates, members).unwrap_or_default();
    // One simulation serves as the foot of all differences.
    let Some(simulated_m) = tips(model, &effects, samples) else { return Vec::new() };
    let simulated_m = simulated_m.as_slice();
    let variants: Vec<(usize, Vec<f64>)> = candidates
        .iter()
        .enumerate()
        .filter(|(_, candidate)| is_asked(candidate))
        .flat_map(|(number, candidate)| {
            candidate.variants().into_iter().map(move |null| (number, null))
        })
        .collect();
    let sensitivity = |(number, null): (usize, Vec<f64>)| {
        let candidate = &candidates[number];
        let column = |&size: &usize| -> Option<Vec<f64>> {
            let step = candidate.probe(size);
            // If one direction cannot be simulated, the other may.
            [step, -step].into_iter().find_map(|step| {
                let effect = candidate.effect(&candidate.moved(&null, size, step))?;
                let there = tips(model, &[effects.as_slice(), &[effect]].concat(), samples)?;
                Some(
                    there
                        .iter()
                        .zip(simulated_m)
                        .map(|(there, here)| (there - here) / step)
                        .collect(),
                )
            })
        };
        let columns: Vec<Vec<f64>> = candidate.sizes().iter().map(column).collect::<Option<_>>()?;
        let columns = DMatrix::from_fn(simulated_m.len(), columns.len(), |row, k| columns[k][row]);
        Some(Sensitivity { candidate: number, null, columns, step: None })
    };
    variants.into_par_iter().filter_map(counted(sensitivity)).collect()
}
