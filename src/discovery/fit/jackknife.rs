//! Leave-one-trial-out errors of a fitted set, to first order (block deletion; Cook & Weisberg,
//! Residuals and Influence, ch. 3).

use nalgebra::{Cholesky, DMatrix, DVector};

use super::gauss_newton::{FitProblem, FittedSet};

/// Rms error on each trial of a fit without it, metres; at most the robot's length, if the other
/// trials do not determine the fit.
pub(crate) fn left_out_errors_m(fit_problem: &FitProblem, fitted: &FittedSet) -> Vec<f64> {
    let samples = fit_problem.samples;
    let noise = &fitted.nuisance_fit.noise;
    let columns = fit_problem.nuisances.with(&fitted.jacobian);
    let white = noise.whitened(samples, &columns);
    let residual = DVector::from_vec(noise.whiten(samples, &fitted.nuisance_fit.residual_m));
    let normal = fit_problem.nuisances.information(&white);
    let length_m = fit_problem.model.robot.backbone.length_m;
    // First order: the optimum without the equations of one trial, from the normal equations of
    // all.
    let one = |range: std::ops::Range<usize>| -> f64 {
        let (start, count) = (3 * range.start, 3 * range.len());
        let in_trial = white.rows(start, count);
        // Change of the optimum without the equations of the trial.
        let reduced: DMatrix<f64> = &normal - in_trial.tr_mul(&in_trial);
        let pull = in_trial.tr_mul(&residual.rows(start, count));
        let Some(factor) = Cholesky::new(reduced) else { return length_m };
        let moved = -factor.solve(&pull);
        let change = columns.rows(start, count) * moved;
        let error = |k: usize| fitted.nuisance_fit.residual_m[start + k] - change[k];
        let error_m =
            ((0..count).map(|k| error(k).powi(2)).sum::<f64>() / range.len().max(1) as f64).sqrt();
        error_m.min(length_m)
    };
    samples.ranges().into_iter().map(one).collect()
}
