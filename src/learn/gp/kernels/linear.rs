//! Linear kernel: Bayesian linear regression through the origin, Rasmussen & Williams 2006, section
//! 2.1.

use super::{DotFormula, DotValue};

/// `k(x, y) = x·y`.
pub struct Linear;

impl DotFormula for Linear {
    const NAME: &'static str = "linear";

    fn at([xy, _, _]: [f64; 3]) -> DotValue {
        DotValue { value: xy, slopes: [1.0, 0.0, 0.0] }
    }
}
