//! Arc-cosine kernel of order 1, the limit of a wide layer of rectified linear units with a bias:
//! Cho & Saul 2009, eqs 3 and 6.

use std::f64::consts::PI;

use super::{DotFormula, DotValue};

/// `k(x, y) = ‖x‖ ‖y‖ (sin θ + (π − θ) cos θ) / π`, θ the angle between x and y, each with a
/// further component 1.
pub struct ArcCosine;

impl DotFormula for ArcCosine {
    const NAME: &'static str = "arc_cosine";

    fn at(products: [f64; 3]) -> DotValue {
        // The further component 1 is the bias of the units.
        let [xy, xx, yy] = products.map(|product| 1.0 + product);
        let norms = (xx * yy).sqrt();
        // Rounding may carry the cosine of equal points beyond 1.
        let cos = (xy / norms).clamp(-1.0, 1.0);
        let (theta, sin) = (cos.acos(), (1.0 - cos * cos).sqrt());
        let value = norms * (sin + (PI - theta) * cos) / PI;
        let along = norms * sin / (2.0 * PI);
        DotValue { value, slopes: [(PI - theta) / PI, along / xx, along / yy] }
    }
}
