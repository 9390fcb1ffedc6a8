//! Measurement noise: its size an axis and its correlation from one sample to the next, and residuals made white by it.

use nalgebra::DMatrix;

use super::samples::Samples;

/// A first-order autoregression, Gaussian, stationary, starting anew in every trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    /// Standard deviation along x, y and z, metres.
    pub(super) sigma_m: [f64; 3],
    /// Correlation over one usual time step.
    pub(super) correlation: f64,
}

/// Correlations beyond this are not told from drift.
const MOST_CORRELATION: f64 = 0.98;
/// Noise is never taken to be smaller than this, metres: a tracker's last digit.
const LEAST_SIGMA_M: f64 = 1e-6;

impl Noise {
    /// Root mean square distance that it makes, metres.
    pub(super) fn rms_m(&self) -> f64 {
        self.sigma_m.iter().map(|sigma| sigma * sigma).sum::<f64>().sqrt()
    }

    /// Independent samples that tell as much about a constant as `samples` correlated ones.
    pub(super) fn independent(&self, samples: usize) -> f64 {
        samples as f64 * (1.0 - self.correlation) / (1.0 + self.correlation)
    }

    /// The columns of a matrix (three rows a sample) as independent numbers of variance one.
    pub(super) fn whitened(&self, samples: &Samples, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut white = columns.clone();
        for mut column in white.column_iter_mut() {
            let values = self.whiten(samples, column.as_slice());
            column.copy_from_slice(&values);
        }
        white
    }

    /// `values` (three numbers a sample) as independent numbers of variance one.
    pub(super) fn whiten(&self, samples: &Samples, values: &[f64]) -> Vec<f64> {
        let mut white = Vec::with_capacity(values.len());
        for row in 0..samples.len() {
            let kept = samples.steps_since_last(row).map_or(0.0, |steps| self.correlation.powf(steps));
            let new = (1.0 - kept * kept).sqrt();
            for axis in 0..3 {
                let at = 3 * row + axis;
                let carried = if kept > 0.0 { kept * values[at - 3] } else { 0.0 };
                white.push((values[at] - carried) / (new * self.sigma_m[axis]));
            }
        }
        white
    }

    /// Logarithm of the determinant of the covariance of all samples.
    pub(super) fn log_determinant(&self, samples: &Samples) -> f64 {
        let axes: f64 = self.sigma_m.iter().map(|sigma| (sigma * sigma).ln()).sum();
        let row = |row: usize| {
            let kept = samples.steps_since_last(row).map_or(0.0, |steps| self.correlation.powf(steps));
            axes + 3.0 * (1.0 - kept * kept).ln()
        };
        (0..samples.len()).map(row).sum()
    }

    /// The most likely noise behind `residual`, of which a fit has used up `freedom` numbers.
    pub(super) fn of(samples: &Samples, residual: &[f64], freedom: f64) -> Noise {
        let ranges = samples.ranges();
        // A negative correlation is no tracker's: it is chance.
        let correlation = correlation(&ranges, residual).clamp(0.0, MOST_CORRELATION);
        let unit = Noise { sigma_m: [1.0; 3], correlation };
        let white = unit.whiten(samples, residual);
        let left = (samples.len() as f64 - freedom / 3.0).max(1.0);
        let sigma = |axis: usize| {
            let sum: f64 = white.iter().skip(axis).step_by(3).map(|w| w * w).sum();
            (sum / left).sqrt().max(LEAST_SIGMA_M)
        };
        Noise { sigma_m: std::array::from_fn(sigma), correlation }
    }
}

/// Correlation of neighbours within trials, axes weighted by their own variance.
fn correlation(ranges: &[std::ops::Range<usize>], residual: &[f64]) -> f64 {
    let mut total = 0.0;
    for axis in 0..3 {
        let at = |row: usize| residual[3 * row + axis];
        let (mut together, mut alone) = (0.0, 0.0);
        for range in ranges.iter().filter(|range| range.len() > 1) {
            let inner = range.start + 1..range.end;
            together += inner.clone().map(|row| at(row) * at(row - 1)).sum::<f64>();
            alone += inner.map(|row| 0.5 * (at(row).powi(2) + at(row - 1).powi(2))).sum::<f64>();
        }
        total += together / alone.max(f64::MIN_POSITIVE) / 3.0;
    }
    total
}
