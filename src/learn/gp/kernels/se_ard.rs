//! Squared exponential with a length-scale per input: paper eq. 18; Rasmussen & Williams 2006, eq.
//! 5.1.

use super::{At, Formula, Lengths};
use crate::learn::simd::exp_f64;

/// `c(s) = exp(−s/2)`.
pub struct SeArd;

impl Formula for SeArd {
    const NAME: &'static str = "se_ard";
    const LENGTHS: Lengths = Lengths::PerInput;

    #[inline(always)]
    fn at(s: f64, _shape: &[f64]) -> At {
        let correlation = exp_f64(-0.5 * s);
        At { correlation, slope: -0.5 * correlation }
    }
}
