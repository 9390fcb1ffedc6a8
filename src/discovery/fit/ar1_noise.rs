//! AR(1) measurement noise: standard deviation by axis, correlation of consecutive samples, and
//! whitening.

use nalgebra::DMatrix;

use crate::discovery::recording::samples::Samples;

/// Stationary Gaussian first-order autoregression, independent by trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ar1Noise {
    /// Standard deviation along x, y and z, metres.
    pub(crate) sigma_m: [f64; 3],
    /// Correlation over one median step of the tracker.
    pub(crate) correlation: f64,
}

/// Correlations above this cannot be told from drift.
const MAX_CORRELATION: f64 = 0.98;
/// Lower bound of the standard deviation, metres: the last digit of a tracker.
pub(crate) const MIN_SIGMA_M: f64 = 1e-6;

impl Ar1Noise {
    /// Root mean square distance, metres.
    pub(crate) fn rms_m(&self) -> f64 {
        self.sigma_m.iter().map(|sigma| sigma * sigma).sum::<f64>().sqrt()
    }

    /// Effective number of independent samples for a mean.
    pub(crate) fn independent(&self, samples: usize) -> f64 {
        samples as f64 * (1.0 - self.correlation) / (1.0 + self.correlation)
    }

    /// Degrees of freedom of the mean square over all axes: three a sample for equal axes, fewer if
    /// one axis is noisier (Satterthwaite, Biometrics Bulletin 2, 1946).
    pub(crate) fn freedom(&self, samples: usize) -> f64 {
        effective_axes(&self.sigma_m.map(|sigma| sigma * sigma)) * self.independent(samples)
    }

    /// Correlation with the previous sample. Steps below the median count as one step.
    fn carried_correlation(&self, samples: &Samples, row: usize) -> f64 {
        samples.steps_since_last(row).map_or(0.0, |steps| self.correlation.powf(steps.max(1.0)))
    }

    /// Whitened columns of a matrix with three rows a sample.
    pub(crate) fn whitened(&self, samples: &Samples, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut white = columns.clone();
        for mut column in white.column_iter_mut() {
            let values = self.whiten(samples, column.as_slice());
            column.copy_from_slice(&values);
        }
        white
    }

    /// Whitened `values` (three a sample): independent, unit variance.
    pub(crate) fn whiten(&self, samples: &Samples, values: &[f64]) -> Vec<f64> {
        let mut white = Vec::with_capacity(values.len());
        for row in 0..samples.len() {
            let correlation = self.carried_correlation(samples, row);
            // The innovation of a stationary AR(1) process has variance σ²(1 − ρ²).
            let new = (1.0 - correlation * correlation).sqrt();
            for axis in 0..3 {
                let at = 3 * row + axis;
                let carried = if correlation > 0.0 { correlation * values[at - 3] } else { 0.0 };
                white.push((values[at] - carried) / (new * self.sigma_m[axis]));
            }
        }
        white
    }

    /// Log-determinant of the covariance of all samples.
    pub(crate) fn log_determinant(&self, samples: &Samples) -> f64 {
        // The whitening matrix is triangular, so its diagonal gives the determinant.
        let axes: f64 = self.sigma_m.iter().map(|sigma| (sigma * sigma).ln()).sum();
        let row = |row: usize| {
            let correlation = self.carried_correlation(samples, row);
            axes + 3.0 * (1.0 - correlation * correlation).ln()
        };
        (0..samples.len()).map(row).sum()
    }

    /// Maximum-likelihood noise of `residual`; a fit has used `freedom` degrees of freedom.
    pub(crate) fn estimate(samples: &Samples, residual: &[f64], freedom: f64) -> Ar1Noise {
        // Negative correlations are attributed to chance.
        let correlation = correlation(samples, residual).clamp(0.0, MAX_CORRELATION);
        let unit = Ar1Noise { sigma_m: [1.0; 3], correlation };
        let white = unit.whiten(samples, residual);
        // Whitened values are independent, so their mean square is the variance.
        let remaining_freedom = (samples.len() as f64 - freedom / 3.0).max(1.0);
        let sigma = |axis: usize| {
            let sum: f64 = white.iter().skip(axis).step_by(3).map(|w| w * w).sum();
            (sum / remaining_freedom).sqrt().max(MIN_SIGMA_M)
        };
        Ar1Noise { sigma_m: std::array::from_fn(sigma), correlation }
    }
}

/// Effective number of axes of a sum of squares with these `variances`.
pub(crate) fn effective_axes(variances: &[f64; 3]) -> f64 {
    let sum: f64 = variances.iter().sum();
    let squares: f64 = variances.iter().map(|variance| variance * variance).sum();
    // Satterthwaite: (Σ σ²)² / Σ σ⁴.
    if squares > 0.0 { sum * sum / squares } else { 3.0 }
}

/// Correlation of consecutive samples, mean over axes with a signal. Pairs farther apart than usual
/// are excluded.
fn correlation(samples: &Samples, residual: &[f64]) -> f64 {
    let neighbours = samples.consecutive_rows();
    let min_m2 = neighbours.len() as f64 * MIN_SIGMA_M.powi(2);
    let of = |axis: usize| {
        let at = |row: usize| residual[3 * row + axis];
        let together: f64 = neighbours.iter().map(|&row| at(row) * at(row - 1)).sum();
        // Both ends of a pair count alike, which keeps the ratio within ±1.
        let alone: f64 =
            neighbours.iter().map(|&row| 0.5 * (at(row).powi(2) + at(row - 1).powi(2))).sum();
        // An axis that never moves has no correlation to average.
        (alone > min_m2).then(|| together / alone)
    };
    let each: Vec<f64> = (0..3).filter_map(of).collect();
    each.iter().sum::<f64>() / each.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discovery::recording::samples::white_noise;

    const NOISE_M: f64 = 5e-4;

    #[test]
    fn one_noisy_axis_is_worth_less_than_three() {
        let noise = |sigma_m| Ar1Noise { sigma_m, correlation: 0.0 };
        assert!((noise([2e-3; 3]).freedom(10) - 30.0).abs() < 1e-9);
        assert!((noise([0.0, 0.0, 1e-3]).freedom(10) - 10.0).abs() < 1e-9);
        assert!((noise([1e-3, 1e-3, 3e-3]).freedom(1) - 121.0 / 83.0).abs() < 1e-9);
    }

    /// Noise has the tracker's time base even if the drives are twice as fast, and a planar tracker
    /// has no third axis.
    #[test]
    fn a_tracker_has_its_own_clock_and_axes() {
        let every_other = |samples: &Samples| {
            let mut seen = samples.clone();
            seen.rows.retain(|sample| sample.row % 2 == 0);
            Samples { tracked_step_s: 0.4, ..seen }
        };
        let samples = every_other(&Samples::alike(40, 100));
        let mut noise = white_noise(NOISE_M, 1);
        let mut residual_m: Vec<f64> = (0..3 * samples.len()).map(|_| noise()).collect();
        for row in 1..samples.len() {
            for axis in 0..2 {
                residual_m[3 * row + axis] =
                    0.8 * residual_m[3 * (row - 1) + axis] + 0.6 * residual_m[3 * row + axis];
            }
        }
        residual_m.iter_mut().skip(2).step_by(3).for_each(|y| *y = 0.0);
        let estimated = Ar1Noise::estimate(&samples, &residual_m, 0.0);
        assert!((estimated.correlation - 0.8).abs() < 0.03, "{estimated:?}");
    }

    /// A row logged late is close to the next one: white noise stays white, with the same size.
    #[test]
    fn uneven_steps_make_no_noise() {
        let mut samples = Samples::alike(8, 50);
        for sample in samples.rows.iter_mut().filter(|sample| sample.row % 5 == 4) {
            sample.time_s += 0.18;
        }
        for seed in 0..20 {
            let mut noise = white_noise(NOISE_M, seed);
            let residual_m: Vec<f64> = (0..3 * samples.len()).map(|_| noise()).collect();
            let estimated = Ar1Noise::estimate(&samples, &residual_m, 0.0);
            assert!(estimated.correlation < 0.1, "{estimated:?}");
            assert!(
                (estimated.rms_m() / (3.0_f64.sqrt() * NOISE_M) - 1.0).abs() < 0.08,
                "{estimated:?}"
            );
        }
    }
}
