//! Nonlinear least squares by Levenberg–Marquardt, with intervals of the parameters.

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Relative change of the sum of squares below which a fit has converged.
const CONVERGENCE_TOLERANCE: f64 = 1e-10;
/// Most accepted steps.
const MAX_ITERATIONS: usize = 60;
/// Largest damping; where no step helps up to it, the parameters are the minimum to rounding.
const MAX_DAMPING: f64 = 1e10;
/// Directions whose singular value is below this share of the largest (columns scaled to unit
/// length) are not identifiable.
const MIN_SINGULAR_VALUE_RATIO: f64 = 1e-7;
/// A parameter with more than this share in an unidentifiable direction has no interval.
const MAX_UNIDENTIFIABLE_SHARE: f64 = 1e-4;

/// A fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Best parameters; a parameter without influence beyond rounding keeps its start value.
    pub parameters: Vec<f64>,
    /// 95 % intervals (Student's t, linearised at the optimum); infinite for unidentifiable
    /// parameters.
    pub interval_95: Vec<[f64; 2]>,
    /// Root mean square of the residuals.
    pub rms: f64,
    /// Whether the sum of squares converged before the iteration limit.
    pub converged: bool,
}

/// Residuals at some parameters; `None` where the model fails.
pub type Residuals<'a> = dyn Fn(&[f64]) -> Option<Vec<f64>> + 'a;
/// Their derivative there: one row per residual, one column per parameter, zero for a parameter
/// without influence.
pub type ResidualJacobian<'a> = dyn Fn(&[f64]) -> Option<DMatrix<f64>> + 'a;

/// Minimises the sum of squares of `residuals(parameters)` from `start` by Levenberg–Marquardt with
/// Marquardt's scaling (Nocedal & Wright, Numerical Optimization, section 10.3). Where the
/// residuals fail, a step is shortened. `None` when residuals or derivative fail at the start or at
/// an accepted step.
pub fn fit(residuals: &Residuals, derivative: &ResidualJacobian, start: &[f64]) -> Option<Fit> {
    let mut at = start.to_vec();
    let mut current = DVector::from_vec(residuals(&at)?);
    let (mut damping, mut converged) = (1e-3, false);
    let mut jacobian = derivative(&at)?;
    for _ in 0..MAX_ITERATIONS {
        let Some((next, residual)) = improve(residuals, &at, &current, &jacobian, &mut damping)
        else {
            converged = true;
            break;
        };
        let before = current.norm_squared();
        (at, current) = (next, residual);
        jacobian = derivative(&at)?;
        converged =
            1.0 - current.norm_squared() / before.max(f64::MIN_POSITIVE) < CONVERGENCE_TOLERANCE;
        if converged {
            break;
        }
    }
    let interval_95 = intervals(&jacobian, &current, &at);
    let rms = (current.norm_squared() / current.len().max(1) as f64).sqrt();
    Some(Fit { parameters: at, interval_95, rms, converged })
}

/// `jacobian` with zero columns for parameters without influence: those whose change by `step`
/// changes the residuals by less than their `accuracy`, in the root mean square.
pub fn unseen_left_out(mut jacobian: DMatrix<f64>, step: f64, accuracy: f64) -> DMatrix<f64> {
    let min_norm = accuracy * (jacobian.nrows() as f64).sqrt() / step;
    for mut column in jacobian.column_iter_mut().filter(|column| column.norm() <= min_norm) {
        column.fill(0.0);
    }
    jacobian
}

/// The first acceptable step, by Marquardt's schedule: `step` at a growing damping, up to
/// `max_damping`. Lowers the damping for the next call after a success.
fn damped<T>(damping: &mut f64, max_damping: f64, step: impl Fn(f64) -> Option<T>) -> Option<T> {
    while *damping < max_damping {
        if let Some(accepted) = step(*damping) {
            *damping = (*damping * 0.2).max(1e-12);
            return Some(accepted);
        }
        *damping *= 10.0;
    }
    None
}

/// Parameters and residuals after a damped step that does not raise the sum of squares; `None` when
/// there is none.
fn improve(
    residuals: &Residuals,
    at: &[f64],
    current: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    damping: &mut f64,
) -> Option<(Vec<f64>, DVector<f64>)> {
    let gradient = jacobian.tr_mul(current);
    let normal = jacobian.tr_mul(jacobian);
    damped(damping, MAX_DAMPING, |damping| {
        let mut damped = normal.clone();
        for k in 0..at.len() {
            // A parameter without influence has a zero gradient and does not move.
            // Marquardt's scaling does not depend on the units of parameters.
            damped[(k, k)] += if normal[(k, k)] > 0.0 { damping * normal[(k, k)] } else { 1.0 };
        }
        let step = Cholesky::new(damped)?.solve(&gradient);
        let candidate: Vec<f64> = at.iter().zip(step.iter()).map(|(x, dx)| x - dx).collect();
        let residual = DVector::from_vec(residuals(&candidate)?);
        (residual.norm_squared() <= current.norm_squared()).then_some((candidate, residual))
    })
}

/// Intervals from the covariance s² (JᵀJ)⁺; infinite for parameters with a share in an
/// unidentifiable direction.
fn intervals(jacobian: &DMatrix<f64>, residual: &DVector<f64>, at: &[f64]) -> Vec<[f64; 2]> {
    let unbounded = [f64::NEG_INFINITY, f64::INFINITY];
    let active: Vec<usize> = (0..at.len()).filter(|&k| jacobian.column(k).norm() > 0.0).collect();
    let mut intervals = vec![unbounded; at.len()];
    if active.is_empty() {
        return intervals;
    }
    let freedom = residual.len() as f64 - active.len() as f64;
    let Ok(student) = StudentsT::new(0.0, 1.0, freedom) else { return intervals };
    let variance = residual.norm_squared() / freedom;
    let quantile = student.inverse_cdf(0.975);
    // Columns of unit length, so that units of parameters do not decide what is identifiable.
    let lengths: Vec<f64> = active.iter().map(|&k| jacobian.column(k).norm()).collect();
    let scaled = DMatrix::from_fn(residual.len(), active.len(), |row, k| {
        jacobian[(row, active[k])] / lengths[k]
    });
    let parts = scaled.svd(false, true);
    let Some(directions) = parts.v_t else { return intervals };
    let smallest = MIN_SINGULAR_VALUE_RATIO * parts.singular_values.max();
    for (k, &parameter) in active.iter().enumerate() {
        let mut is_unidentifiable = false;
        let mut inverse = 0.0;
        for (direction, &size) in directions.row_iter().zip(parts.singular_values.iter()) {
            if size > smallest {
                inverse += (direction[k] / size).powi(2);
            } else {
                is_unidentifiable |= direction[k].abs() > MAX_UNIDENTIFIABLE_SHARE;
            }
        }
        if !is_unidentifiable {
            let half = quantile * (variance * inverse).sqrt() / lengths[k];
            intervals[parameter] = [at[parameter] - half, at[parameter] + half];
        }
    }
    intervals
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Central differences.
    fn differences(
        residuals: &Residuals,
        at: &[f64],
        step: f64,
        accuracy: f64,
    ) -> Option<DMatrix<f64>> {
        let shifted = |k: usize, by: f64| {
            let mut moved = at.to_vec();
            moved[k] += by;
            residuals(&moved).map(DVector::from_vec)
        };
        let columns: Vec<DVector<f64>> = (0..at.len())
            .map(|k| Some((shifted(k, step)? - shifted(k, -step)?) / (2.0 * step)))
            .collect::<Option<_>>()?;
        Some(unseen_left_out(DMatrix::from_columns(&columns), step, accuracy))
    }

    fn found(residuals: &Residuals, start: &[f64], step: f64, accuracy: f64) -> Fit {
        fit(residuals, &|at| differences(residuals, at, step, accuracy), start).unwrap()
    }

    #[test]
    fn an_exponential_decay_comes_back() {
        let times: Vec<f64> = (0..40).map(|k| f64::from(k) * 0.1).collect();
        let wobble = |k: usize| 1e-3 * (k as f64 * 12.9898).sin();
        let data: Vec<f64> =
            times.iter().enumerate().map(|(k, t)| 2.0 * (-1.5 * t).exp() + wobble(k)).collect();
        let residuals = |p: &[f64]| {
            Some(times.iter().zip(&data).map(|(t, y)| p[0] * (-p[1] * t).exp() - y).collect())
        };
        let fit = found(&residuals, &[1.0, 0.5], 1e-5, 1e-14);
        assert!(fit.converged);
        for (value, interval) in [2.0, 1.5].iter().zip(&fit.interval_95) {
            assert!(interval[0] < *value && *value < interval[1], "{fit:?}");
        }
    }

    /// A parameter that does nothing, or only rounding, neither holds up the others nor gets an
    /// interval; of a pair that acts as a product each is unknown, and a third one is not drawn in.
    #[test]
    fn what_the_data_do_not_see_has_no_interval_and_harms_no_other() {
        let data: Vec<f64> =
            (0..30).map(|k| 3.0 * f64::from(k) + 1.0 + 0.01 * f64::from(k).sin()).collect();
        let line = |slope: f64, shift: f64, noise: f64| {
            let wobble = move |k: usize| noise * ((k * 7919 % 13) as f64 - 6.0);
            Some(
                data.iter()
                    .enumerate()
                    .map(|(k, y)| slope * k as f64 + shift + wobble(k) - y)
                    .collect::<Vec<f64>>(),
            )
        };
        let idle = |p: &[f64]| line(p[0], p[1], 1e-12 * (1e9 * p[2]).sin());
        let fitted = found(&idle, &[1.0, 0.0, 5.0], 1e-4, 1e-10);
        assert!(
            (fitted.parameters[0] - 3.0).abs() < 1e-3 && (fitted.parameters[1] - 1.0).abs() < 1e-2,
            "{fitted:?}"
        );
        assert!(
            fitted.parameters[2] == 5.0 && fitted.interval_95[2][1].is_infinite(),
            "{fitted:?}"
        );
        assert!(fitted.interval_95[0][1] - fitted.interval_95[0][0] < 1e-3, "{fitted:?}");

        let product = |p: &[f64]| line(p[0] * p[1], p[2], 0.0);
        let fitted = found(&product, &[1.0, 1.0, 0.0], 1e-5, 1e-14);
        assert!((fitted.parameters[0] * fitted.parameters[1] - 3.0).abs() < 1e-3, "{fitted:?}");
        let unknown = fitted
            .interval_95
            .iter()
            .map(|interval| interval[1].is_infinite())
            .collect::<Vec<bool>>();
        assert_eq!(unknown, [true, true, false], "{fitted:?}");
    }
}
