//! Diagonally implicit Runge–Kutta schemes, all stiffly accurate and L-stable.

use serde::{Deserialize, Serialize};

/// Time integration scheme.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// Implicit Euler, order 1.
    Euler,
    /// Alexander's two-stage scheme, γ = 1 − 1/√2, order 2 (Hairer & Wanner, Solving ODEs II, table
    /// IV.6.5).
    Sdirk2,
    /// Alexander's three-stage scheme, γ ≈ 0.4359, order 3 (Alexander 1977).
    #[default]
    Sdirk3,
}

/// Coefficients of a scheme: each row ends with the diagonal γ.
#[derive(Clone, Debug)]
pub(crate) struct Tableau {
    pub(crate) rows: Vec<Vec<f64>>,
}

impl Scheme {
    pub(crate) fn tableau(self) -> Tableau {
        match self {
            Scheme::Euler => Tableau { rows: vec![vec![1.0]] },
            Scheme::Sdirk2 => {
                let g = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
                Tableau { rows: vec![vec![g], vec![1.0 - g, g]] }
            }
            Scheme::Sdirk3 => {
                // The root of γ³ − 3γ² + 3γ/2 − 1/6 between 1/6 and 1/2.
                let g = 0.435_866_521_508_459;
                let last = [
                    -(6.0 * g * g - 16.0 * g + 1.0) / 4.0,
                    (6.0 * g * g - 20.0 * g + 5.0) / 4.0,
                    g,
                ];
                Tableau { rows: vec![vec![g], vec![(1.0 - g) / 2.0, g], last.to_vec()] }
            }
        }
    }
}
