//! One member of a network in use.

use super::kinds::{HiddenUnit, MAX_SUMS};
use super::weights::{Sizes, Weights};
use crate::math::vectorised;

/// The hidden units' values and memories between two steps, all zero after a reset; and room for
/// the units' sums.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MemberState {
    values: Vec<f32>,
    memories: Vec<f32>,
    pub(super) sums: Vec<f32>,
}

impl MemberState {
    pub(super) fn new(sizes: Sizes) -> Self {
        let units = sizes.units();
        MemberState {
            values: vec![0.0; units],
            memories: vec![0.0; units],
            sums: vec![0.0; sizes.row_len()],
        }
    }

    pub(super) fn reset(&mut self) {
        self.values.fill(0.0);
        self.memories.fill(0.0);
    }

    /// One step of a network of `C`: from standardised inputs to standardised outputs.
    pub(super) fn advance<C: HiddenUnit>(
        weights: &Weights<f32>,
        state: &mut MemberState,
        input: &[f32],
        out: &mut [f32],
    ) {
        let Sizes { hidden, .. } = weights.sizes;
        let (units, ports, stride) =
            (weights.sizes.units(), weights.sizes.ports(), weights.sizes.row_len());
        let remembers = C::SUMS.iter().any(|block| block.state);
        vectorised!({
            let [from_inputs, from_state, bias] = weights.hidden();
            let MemberState { values, memories, sums } = state;
            sums.copy_from_slice(bias);
            for (row, &x) in from_inputs.chunks_exact(stride).zip(input) {
                add_scaled(sums, row, x);
            }
            if remembers {
                for (row, &h) in from_state.chunks_exact(stride).zip(values.iter()) {
                    add_scaled(sums, row, h);
                }
            }
            let sums: [&[f32]; MAX_SUMS] =
                // Sums that a kind does not have read some row; its unit ignores them.
                std::array::from_fn(|block| sums.get(block * units..(block + 1) * units).unwrap_or(&sums[..units]));
            let (values, memories) = (&mut values[..units], &mut memories[..units]);
            for u in 0..units {
                let after = C::forward(
                    &std::array::from_fn(|block| sums[block][u]),
                    values[u],
                    memories[u],
                );
                (values[u], memories[u]) = (after.value, after.memory);
            }
            let (from_hidden, bias) = weights.output().split_at(hidden * ports);
            for (o, out) in out.iter_mut().enumerate() {
                let terms = from_hidden.chunks_exact(ports).zip(values.iter());
                *out = terms.fold(bias[o], |sum, (row, &h)| row[o].mul_add(h, sum));
            }
        });
    }
}

/// `out += scale · row`.
#[inline(always)]
fn add_scaled(out: &mut [f32], row: &[f32], scale: f32) {
    for (out, w) in out.iter_mut().zip(row) {
        *out = w.mul_add(scale, *out);
    }
}
