//! Long short-term memory (Hochreiter & Schmidhuber 1997, with the forget gate of Gers, Schmidhuber
//! & Cummins 2000):
//!
//! `i, f, o = σ(W x + U h + b)`, `g = tanh(W_g x + U_g h + b_g)`, `c' = f ⊙ c + i ⊙ g`, `h' = o ⊙
//! tanh(c')`.

use super::{Backward, Forward, HiddenUnit, MAX_SUMS, Past, WeightedSum, sigmoid};
use crate::learn::simd::Real;

pub(super) struct Lstm;

impl HiddenUnit for Lstm {
    /// Input gate, forget gate, candidate and output gate: PyTorch's order.
    const SUMS: &'static [WeightedSum] = &[WeightedSum::BOTH; 4];
    const SAVED: usize = 5;
    const MEMORY: bool = true;

    #[inline(always)]
    fn forward<T: Real>(sums: &[T; MAX_SUMS], _: T, memory_before: T) -> Forward<T> {
        let [input, forget, output] = [sigmoid(sums[0]), sigmoid(sums[1]), sigmoid(sums[3])];
        let candidate = sums[2].tanh_fast();
        let memory = forget.fma(memory_before, input * candidate);
        let shown = memory.tanh_fast();
        Forward { value: output * shown, memory, saved: [input, forget, candidate, output, shown] }
    }

    #[inline(always)]
    fn backward<T: Real>(past: &Past<T>) -> Backward<T> {
        let one = T::of(1.0);
        let [input, forget, candidate, output, shown] = past.saved;
        // The memory acts through the value now and through the memory of later steps.
        let d_memory = (past.d_value * output).fma((-shown).fma(shown, one), past.d_memory);
        let gate = |value: T| value * (one - value);
        Backward {
            d_sums: [
                d_memory * candidate * gate(input),
                d_memory * past.memory_before * gate(forget),
                d_memory * input * (-candidate).fma(candidate, one),
                past.d_value * shown * gate(output),
            ],
            d_value_before: T::default(),
            d_memory_before: d_memory * forget,
        }
    }
}
