//! Matérn kernel of smoothness 1/2 (exponential), continuous but not differentiable: Rasmussen &
//! Williams 2006, eq. 4.18.

use super::{At, Formula, Lengths};
use crate::learn::simd::exp_f64;

/// `c(s) = exp(−√s)`.
pub struct Matern12Ard;

/// The slope is infinite at s = 0, where every squared distance that multiplies it is zero.
const MIN_DISTANCE: f64 = 1e-100;

impl Formula for Matern12Ard {
    const NAME: &'static str = "matern12_ard";
    const LENGTHS: Lengths = Lengths::PerInput;

    #[inline(always)]
    fn at(s: f64, _shape: &[f64]) -> At {
        let a = s.sqrt();
        let correlation = exp_f64(-a);
        At { correlation, slope: -0.5 * correlation / a.max(MIN_DISTANCE) }
    }
}
