//! Polynomial kernel of degree 3: Rasmussen & Williams 2006, section 4.2.2.

use super::{DotFormula, DotValue};

/// `k(x, y) = (1 + x·y)³`.
pub struct Cubic;

impl DotFormula for Cubic {
    const NAME: &'static str = "cubic";

    fn at([xy, _, _]: [f64; 3]) -> DotValue {
        let base = 1.0 + xy;
        DotValue { value: base * base * base, slopes: [3.0 * base * base, 0.0, 0.0] }
    }
}
