//! Stored form of a fitted process: samples and hyper-parameters. The factors are recomputed on
//! reading.

use serde::{Deserialize, Serialize};

use super::{
    Approximation, FoldOrder, Gp, GpConfig, KernelExpression, Lambda, MeanFunction, NoisePrior,
};
use crate::base::Rows;
use crate::learn::selection::Selection;
use crate::learn::{LearnError, exact};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StoredGp {
    #[serde(with = "StoredConfig")]
    config: GpConfig,
    inputs: StoredRows,
    outputs: StoredRows,
    hyperparameters: StoredRows,
    evaluations: usize,
}

/// The settings of the fit, every one of them: the format of the store leaves no field out. How
/// rows were chosen is no part of a fit.
#[derive(Serialize, Deserialize)]
#[serde(remote = "GpConfig", deny_unknown_fields)]
struct StoredConfig {
    kernel: KernelExpression,
    mean: MeanFunction,
    approximation: Approximation,
    inducing_points: usize,
    #[serde(skip)]
    selection: Selection,
    lambda: Lambda,
    starts: usize,
    start_rows: usize,
    noise_floor: f64,
    noise_prior: Option<NoisePrior>,
    tolerance: f64,
    folds: usize,
    fold_order: FoldOrder,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredRows {
    width: usize,
    #[serde(with = "exact::f64s")]
    values: Vec<f64>,
}

impl StoredRows {
    fn of(rows: &Rows) -> Self {
        StoredRows { width: rows.width(), values: rows.values().to_vec() }
    }

    fn rows(&self) -> Result<Rows, LearnError> {
        if self.width == 0 || !self.values.len().is_multiple_of(self.width) {
            let what = "numbers in a stored table";
            return Err(LearnError::Shape { what, found: self.values.len(), expected: self.width });
        }
        let mut rows = Rows::new(self.width);
        self.values.chunks_exact(self.width).for_each(|row| rows.push(row));
        Ok(rows)
    }
}

impl From<Gp> for StoredGp {
    fn from(gp: Gp) -> Self {
        let width = gp.theta.first().map_or(0, Vec::len);
        StoredGp {
            inputs: StoredRows::of(&gp.inputs),
            outputs: StoredRows::of(&gp.outputs),
            hyperparameters: StoredRows { width, values: gp.theta.concat() },
            evaluations: gp.evaluations,
            config: gp.config,
        }
    }
}

impl TryFrom<StoredGp> for Gp {
    type Error = LearnError;

    fn try_from(stored: StoredGp) -> Result<Gp, LearnError> {
        let theta = stored.hyperparameters.rows()?.iter().map(<[f64]>::to_vec).collect();
        Gp::condition(
            &stored.inputs.rows()?,
            &stored.outputs.rows()?,
            &stored.config,
            theta,
            stored.evaluations,
        )
    }
}
