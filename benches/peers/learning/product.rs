//! The processor's peak as far as software reaches it: a large matrix product on one thread.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

use crate::clock;

/// Processor time of a product of two square matrices, s: double or single precision.
pub fn cpu_s(size: usize, double: bool) -> f64 {
    if double { of(size, |value| value) } else { of(size, |value| value as f32) }
}

fn of<T: faer::traits::ComplexField>(size: usize, number: impl Fn(f64) -> T) -> f64 {
    let left = Mat::from_fn(size, size, |i, j| number((1.7 * i as f64 + 0.3 * j as f64).sin()));
    let mut out = Mat::<T>::zeros(size, size);
    let one = number(1.0);
    clock::mean(|| {
        matmul(out.as_mut(), Accum::Replace, left.as_ref(), left.as_ref(), one.clone(), Par::Seq)
    })
    .1
}
