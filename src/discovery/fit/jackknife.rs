//! How well a fitted set does on trials that its fit has not seen: each trial is left out in turn, and the fit moved to
//! where it would be without it, to first order (deletion of a block; Cook & Weisberg, Residuals and Influence, ch. 3).

use nalgebra::{Cholesky, DMatrix, DVector};

use super::gauss_newton::{Fitted, Study};

/// For each trial, the root mean square error that a fit without it makes there, metres; at most the robot's length, which
/// says that the other trials know nothing of it.
pub(crate) fn unseen_m(study: &Study, fitted: &Fitted) -> Vec<f64> {
    let samples = study.samples;
    let noise = &fitted.explained.noise;
    let plain = study.nuisances.with(&fitted.jacobian);
    let white = noise.whitened(samples, &plain);
    let left = DVector::from_vec(noise.whiten(samples, &fitted.explained.left_m));
    let normal = study.nuisances.information(&white);
    let length_m = study.model.robot.backbone.length_m;
    let one = |range: std::ops::Range<usize>| -> f64 {
        let (start, count) = (3 * range.start, 3 * range.len());
        let own = white.rows(start, count);
        // Without the trial's equations the optimum moves by this much.
        let reduced: DMatrix<f64> = &normal - own.tr_mul(&own);
        let pull = own.tr_mul(&left.rows(start, count));
        let Some(factor) = Cholesky::new(reduced) else { return length_m };
        let moved = -factor.solve(&pull);
        let change = plain.rows(start, count) * moved;
        let error = |k: usize| fitted.explained.left_m[start + k] - change[k];
        let error_m = ((0..count).map(|k| error(k).powi(2)).sum::<f64>() / range.len().max(1) as f64).sqrt();
        error_m.min(length_m)
    };
    samples.ranges().into_iter().map(one).collect()
}
