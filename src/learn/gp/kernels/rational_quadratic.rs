//! Rational quadratic with a length-scale per input, a mixture of squared exponentials of many
//! length-scales: Rasmussen & Williams 2006, eq. 4.19. It tends to `se_ard` as α grows.

use super::{At, Formula, Lengths, ShapeParameter};

/// `c(s) = (1 + s / 2α)^−α`.
pub struct RationalQuadratic;

impl Formula for RationalQuadratic {
    const NAME: &'static str = "rational_quadratic";
    const LENGTHS: Lengths = Lengths::PerInput;
    const SHAPES: &'static [ShapeParameter] =
        &[ShapeParameter { name: "alpha", start: 2.0, bounds: (1e-2, 1e3) }];

    #[inline(always)]
    fn at(s: f64, shape: &[f64]) -> At {
        let base = 1.0 + s / (2.0 * shape[0]);
        let correlation = base.powf(-shape[0]);
        At { correlation, slope: -0.5 * correlation / base }
    }

    fn shape_slope(s: f64, shape: &[f64], _index: usize) -> f64 {
        let ratio = s / (2.0 * shape[0]);
        let base = 1.0 + ratio;
        // `ln_1p` keeps its digits for large α, where the kernel tends to `se_ard`.
        shape[0] * base.powf(-shape[0]) * (ratio / base - ratio.ln_1p())
    }
}
