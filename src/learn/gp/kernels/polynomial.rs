//! Polynomial kernel of degree 2: Rasmussen & Williams 2006, section 4.2.2.

use super::{DotFormula, DotValue};

/// `k(x, y) = (1 + x·y)²`.
pub struct Polynomial;

impl DotFormula for Polynomial {
    const NAME: &'static str = "polynomial";

    fn at([xy, _, _]: [f64; 3]) -> DotValue {
        let base = 1.0 + xy;
        DotValue { value: base * base, slopes: [2.0 * base, 0.0, 0.0] }
    }
}
