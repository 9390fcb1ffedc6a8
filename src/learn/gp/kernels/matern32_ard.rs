//! Matérn kernel of smoothness 3/2, once differentiable: Rasmussen & Williams 2006, eq. 4.17.

use super::{At, Formula, Lengths};
use crate::learn::simd::exp_f64;

/// `c(s) = (1 + √(3s)) exp(−√(3s))`.
pub struct Matern32Ard;

impl Formula for Matern32Ard {
    const NAME: &'static str = "matern32_ard";
    const LENGTHS: Lengths = Lengths::PerInput;

    #[inline(always)]
    fn at(s: f64, _shape: &[f64]) -> At {
        let a = (3.0 * s).sqrt();
        let decay = exp_f64(-a);
        At { correlation: (1.0 + a) * decay, slope: -1.5 * decay }
    }
}
