//! Constant kernel: an unknown offset of the whole function.

use super::component::{Component, Hyperparameter, PairRow};

/// `k(x, y) = 1`.
pub struct Constant;

impl Component for Constant {
    fn name(&self) -> &'static str {
        "constant"
    }

    fn hyperparameters(&self, _inputs: usize) -> Vec<Hyperparameter> {
        Vec::new()
    }

    fn values(&self, _parameters: &[f64], _row: &PairRow, out: &mut [f64]) {
        out.fill(1.0);
    }

    fn rates(&self, _parameters: &[f64], _row: &PairRow, _out: &mut [Vec<f64>]) {}

    fn variance(&self, _parameters: &[f64], _at: &[f64]) -> f64 {
        1.0
    }
}
