//! Nonlinear least squares by Levenberg–Marquardt with finite-difference derivatives, and what the data say of the
//! parameters.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Relative change of the sum of squares below which a fit has converged.
const CONVERGED: f64 = 1e-10;
const MOST_ITERATIONS: usize = 60;

/// A fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Best parameters.
    pub parameters: Vec<f64>,
    /// 95 % intervals (Student's t, linearised at the optimum); infinite where the data say nothing.
    pub interval_95: Vec<[f64; 2]>,
    /// Root mean square of the residuals.
    pub rms: f64,
    /// Whether the sum of squares stopped falling before the iteration limit.
    pub converged: bool,
}

/// Minimises the sum of squares of `residuals(parameters)` from `start`; `steps` are the parameter changes of the
/// finite differences. `residuals` returns `None` where the model has no answer: such a step is shortened.
/// Levenberg–Marquardt with Marquardt's scaling (Nocedal & Wright, Numerical Optimization, section 10.3).
/// `None` when there is no answer at the start.
pub fn fit(residuals: &dyn Fn(&[f64]) -> Option<Vec<f64>>, start: &[f64], steps: &[f64]) -> Option<Fit> {
    let mut at = start.to_vec();
    let mut current = DVector::from_vec(residuals(&at)?);
    let (mut damping, mut converged) = (1e-3, false);
    let mut jacobian = derivative(residuals, &at, &current, steps)?;
    for _ in 0..MOST_ITERATIONS {
        let gradient = jacobian.tr_mul(&current);
        let normal = jacobian.tr_mul(&jacobian);
        let mut improved = false;
        while damping < 1e10 {
            let mut damped = normal.clone();
            for k in 0..at.len() {
                damped[(k, k)] += damping * normal[(k, k)].max(1e-300);
            }
            let Some(step) = damped.cholesky().map(|factor| factor.solve(&gradient)) else {
                damping *= 10.0;
                continue;
            };
            let candidate: Vec<f64> = at.iter().zip(step.iter()).map(|(x, dx)| x - dx).collect();
            match residuals(&candidate).map(DVector::from_vec) {
                Some(next) if next.norm_squared() <= current.norm_squared() => {
                    let gain = 1.0 - next.norm_squared() / current.norm_squared().max(f64::MIN_POSITIVE);
                    (at, current, improved) = (candidate, next, true);
                    converged = gain < CONVERGED;
                    damping = (damping * 0.2).max(1e-12);
                    break;
                }
                _ => damping *= 10.0,
            }
        }
        // No step of any length helps: this is the minimum to rounding.
        converged |= !improved;
        if converged {
            break;
        }
        jacobian = derivative(residuals, &at, &current, steps)?;
    }
    let interval_95 = intervals(&jacobian, &current, &at);
    let rms = (current.norm_squared() / current.len().max(1) as f64).sqrt();
    Some(Fit { parameters: at, interval_95, rms, converged })
}

/// Central differences.
fn derivative(
    residuals: &dyn Fn(&[f64]) -> Option<Vec<f64>>,
    at: &[f64],
    current: &DVector<f64>,
    steps: &[f64],
) -> Option<DMatrix<f64>> {
    let mut jacobian = DMatrix::zeros(current.len(), at.len());
    for (k, &step) in steps.iter().enumerate() {
        let shifted = |sign: f64| {
            let mut moved = at.to_vec();
            moved[k] += sign * step;
            residuals(&moved)
        };
        let (after, before) = (shifted(1.0)?, shifted(-1.0)?);
        for (row, (a, b)) in after.iter().zip(&before).enumerate() {
            jacobian[(row, k)] = (a - b) / (2.0 * step);
        }
    }
    Some(jacobian)
}

fn intervals(jacobian: &DMatrix<f64>, residual: &DVector<f64>, at: &[f64]) -> Vec<[f64; 2]> {
    let freedom = residual.len() as f64 - at.len() as f64;
    let nothing = vec![[f64::NEG_INFINITY, f64::INFINITY]; at.len()];
    let Some(covariance) = jacobian.tr_mul(jacobian).try_inverse() else { return nothing };
    let Ok(student) = StudentsT::new(0.0, 1.0, freedom) else { return nothing };
    let variance = residual.norm_squared() / freedom;
    let quantile = student.inverse_cdf(0.975);
    let half = |k: usize| quantile * (variance * covariance[(k, k)]).sqrt();
    at.iter().enumerate().map(|(k, &value)| [value - half(k), value + half(k)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exponential_decay_comes_back() {
        let times: Vec<f64> = (0..40).map(|k| f64::from(k) * 0.1).collect();
        let wobble = |k: usize| 1e-3 * (k as f64 * 12.9898).sin();
        let data: Vec<f64> = times.iter().enumerate().map(|(k, t)| 2.0 * (-1.5 * t).exp() + wobble(k)).collect();
        let residuals = |p: &[f64]| Some(times.iter().zip(&data).map(|(t, y)| p[0] * (-p[1] * t).exp() - y).collect());
        let fit = fit(&residuals, &[1.0, 0.5], &[1e-5, 1e-5]).unwrap();
        assert!(fit.converged);
        for (value, interval) in [2.0, 1.5].iter().zip(&fit.interval_95) {
            assert!(interval[0] < *value && *value < interval[1], "{fit:?}");
        }
    }
}
