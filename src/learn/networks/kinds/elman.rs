//! Elman 1990: `h' = tanh(W_x x + W_h h + b)`.

use super::{Backward, Forward, HiddenUnit, MAX_SAVED, MAX_SUMS, Past, WeightedSum};
use crate::learn::simd::Real;

pub(super) struct Elman;

impl HiddenUnit for Elman {
    const SUMS: &'static [WeightedSum] = &[WeightedSum::BOTH];

    #[inline(always)]
    fn forward<T: Real>(sums: &[T; MAX_SUMS], _: T, _: T) -> Forward<T> {
        Forward {
            value: sums[0].tanh_fast(),
            memory: T::default(),
            saved: [T::default(); MAX_SAVED],
        }
    }

    #[inline(always)]
    fn backward<T: Real>(past: &Past<T>) -> Backward<T> {
        let mut d_sums = [T::default(); MAX_SUMS];
        // tanh′ = 1 − tanh².
        d_sums[0] = past.d_value * (-past.value).fma(past.value, T::of(1.0));
        Backward { d_sums, d_value_before: T::default(), d_memory_before: T::default() }
    }
}
