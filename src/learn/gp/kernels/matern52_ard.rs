//! Matérn kernel of smoothness 5/2, twice differentiable: Rasmussen & Williams 2006, eq. 4.17.

use super::{At, Formula, Lengths};
use crate::learn::simd::exp_f64;

/// `c(s) = (1 + √(5s) + 5s/3) exp(−√(5s))`.
pub struct Matern52Ard;

impl Formula for Matern52Ard {
    const NAME: &'static str = "matern52_ard";
    const LENGTHS: Lengths = Lengths::PerInput;

    #[inline(always)]
    fn at(s: f64, _shape: &[f64]) -> At {
        let a = (5.0 * s).sqrt();
        let decay = exp_f64(-a);
        At { correlation: (1.0 + a + 5.0 / 3.0 * s) * decay, slope: -5.0 / 6.0 * (1.0 + a) * decay }
    }
}
