//! Standardisation of columns to zero mean and unit standard deviation, and its inverse.

use serde::{Deserialize, Serialize};

use super::{LearnError, exact};
use crate::base::Rows;

/// Mean and population standard deviation of each column. A constant column keeps its values'
/// offset and gets scale 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Standardiser {
    #[serde(with = "exact::f64s")]
    mean: Vec<f64>,
    #[serde(with = "exact::f64s")]
    scale: Vec<f64>,
}

impl Standardiser {
    /// Measures the columns of the rows numbered `which`.
    pub fn fit(rows: &Rows, which: &[usize]) -> Self {
        let count = which.len().max(1) as f64;
        let mut mean = vec![0.0; rows.width()];
        for &index in which {
            mean.iter_mut().zip(rows.row(index)).for_each(|(m, v)| *m += v / count);
        }
        let mut scale = vec![0.0; rows.width()];
        for &index in which {
            let row = rows.row(index);
            scale
                .iter_mut()
                .zip(row.iter().zip(&mean))
                .for_each(|(s, (v, m))| *s += (v - m) * (v - m) / count);
        }
        for (s, m) in scale.iter_mut().zip(&mean) {
            let deviation = s.sqrt();
            // A spread that is rounding beside the mean is that of a constant column.
            *s = if deviation > 1e-12 * m.abs().max(1e-300) { deviation } else { 1.0 };
        }
        Standardiser { mean, scale }
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.mean.len()
    }

    /// Standard deviation of column `column`, in its own unit.
    pub fn scale(&self, column: usize) -> f64 {
        self.scale[column]
    }

    /// From the column's unit to standard deviations.
    #[inline]
    pub fn apply(&self, column: usize, value: f64) -> f64 {
        (value - self.mean[column]) / self.scale[column]
    }

    /// From standard deviations to the column's unit.
    #[inline]
    pub fn invert(&self, column: usize, value: f64) -> f64 {
        value.mul_add(self.scale[column], self.mean[column])
    }
}

/// Checks that inputs and outputs have equal length and hold only finite numbers.
pub(crate) fn check_samples(inputs: &Rows, outputs: &Rows) -> Result<(), LearnError> {
    LearnError::unless_shape("rows of outputs", outputs.len(), inputs.len())?;
    for (what, rows) in [("columns of inputs", inputs), ("columns of outputs", outputs)] {
        LearnError::unless_shape(what, rows.width().min(1), 1)?;
    }
    check_finite("inputs", inputs)?;
    check_finite("outputs", outputs)
}

/// Names the first number of a table that is not finite.
pub(crate) fn check_finite(table: &'static str, rows: &Rows) -> Result<(), LearnError> {
    rows.iter()
        .enumerate()
        .try_for_each(|(row, values)| LearnError::unless_finite(table, row, values))
}
