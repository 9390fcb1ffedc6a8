//! `h = tanh(W x + b)`, x the last `history` rows of inputs.

use super::elman::Elman;
use super::{Backward, Forward, HiddenUnit, MAX_SUMS, Past, WeightedSum};
use crate::learn::simd::Real;

pub(super) struct FeedForward;

impl HiddenUnit for FeedForward {
    const SUMS: &'static [WeightedSum] = &[WeightedSum::INPUTS];

    #[inline(always)]
    fn forward<T: Real>(sums: &[T; MAX_SUMS], value_before: T, memory_before: T) -> Forward<T> {
        Elman::forward(sums, value_before, memory_before)
    }

    #[inline(always)]
    fn backward<T: Real>(past: &Past<T>) -> Backward<T> {
        Elman::backward(past)
    }
}
