//! Constant kernel: an unknown offset of the whole function.

use super::component::{Component, PairRow};

/// `k(x, y) = 1`.
pub struct Constant;

impl Component for Constant {
    fn name(&self) -> &'static str {
        "constant"
    }

    fn values(&self, _parameters: &[f64], _row: &PairRow, out: &mut [f64]) {
        out.fill(1.0);
    }
}
