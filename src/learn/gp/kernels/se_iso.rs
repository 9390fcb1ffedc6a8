//! Squared exponential with one length-scale: Rasmussen & Williams 2006, eq. 4.9.

use super::{At, Formula, Lengths, SeArd};

/// `c(s) = exp(−s/2)`.
pub struct SeIso;

impl Formula for SeIso {
    const NAME: &'static str = "se_iso";
    const LENGTHS: Lengths = Lengths::Shared;

    #[inline(always)]
    fn at(s: f64, shape: &[f64]) -> At {
        SeArd::at(s, shape)
    }
}
