//! Gated recurrent units, in the form of PyTorch's `nn.GRU` (Cho et al. 2014, with the reset gate
//! on the product with the recurrent weights):
//!
//! `r = σ(W_r x + U_r h + b_r)`, `z = σ(W_z x + U_z h + b_z)`, `n = tanh(W_n x + b_n + r ⊙ (U_n h +
//! c_n))`, `h' = (1 − z) ⊙ n + z ⊙ h`.

use super::{Backward, Forward, HiddenUnit, MAX_SUMS, Past, WeightedSum, sigmoid};
use crate::learn::simd::Real;

pub(super) struct Gru;

impl HiddenUnit for Gru {
    /// Reset gate, update gate, and the candidate's sums over inputs and over the state.
    const SUMS: &'static [WeightedSum] =
        &[WeightedSum::BOTH, WeightedSum::BOTH, WeightedSum::INPUTS, WeightedSum::STATE];
    const SAVED: usize = 4;
    const CARRIES: bool = true;

    #[inline(always)]
    fn forward<T: Real>(sums: &[T; MAX_SUMS], value_before: T, _: T) -> Forward<T> {
        let [reset, update] = [sigmoid(sums[0]), sigmoid(sums[1])];
        let from_state = sums[3];
        let candidate = reset.fma(from_state, sums[2]).tanh_fast();
        // (1 − z) n + z h as n + z (h − n): one product less.
        let value = update.fma(value_before - candidate, candidate);
        Forward {
            value,
            memory: T::default(),
            saved: [reset, update, candidate, from_state, T::default()],
        }
    }

    #[inline(always)]
    fn backward<T: Real>(past: &Past<T>) -> Backward<T> {
        let one = T::of(1.0);
        let [reset, update, candidate, from_state, _] = past.saved;
        // tanh′ = 1 − n² and σ′ = σ (1 − σ) throughout.
        let d_candidate = past.d_value * (one - update) * (-candidate).fma(candidate, one);
        let d_update = past.d_value * (past.value_before - candidate) * update * (one - update);
        let d_reset = d_candidate * from_state * reset * (one - reset);
        Backward {
            d_sums: [d_reset, d_update, d_candidate, d_candidate * reset],
            d_value_before: past.d_value * update,
            d_memory_before: T::default(),
        }
    }
}
