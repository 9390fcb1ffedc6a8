//! White noise: every sample has a part of its own that no other sample shares and no prediction
//! knows.

use super::component::{Component, PairRow};

/// `k(x, y) = 1` for a training point with itself, otherwise 0.
pub struct White;

impl Component for White {
    fn name(&self) -> &'static str {
        "white"
    }

    fn values(&self, _parameters: &[f64], row: &PairRow, out: &mut [f64]) {
        out.fill(0.0);
        if let Some(self_index) = row.self_index {
            out[self_index] = 1.0;
        }
    }

    fn variance(&self, _parameters: &[f64], _at: &[f64]) -> f64 {
        0.0
    }
}
