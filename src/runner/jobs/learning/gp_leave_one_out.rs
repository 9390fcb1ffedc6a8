//! How a Gaussian process foretells each of its own points from all others.

use crate::learn::gp::Gp;
use crate::math::distribution::normal_quantile;
use crate::rows::experiment::GpLeftOut;
use crate::runner::graph::stage::{Handle, Stage, StageKind};

/// By axis and promised share, which are the parameters.
pub(crate) const GP_LEAVE_ONE_OUT: Stage<Vec<f64>, Handle<Gp>, Vec<GpLeftOut>> = Stage {
    kind: StageKind { name: "gp_leave_one_out", module: module_path!(), cost_ms: 50 },
    job: |shares, gp| Ok(rows(gp, shares)),
};

fn rows(gp: &Gp, shares: &[f64]) -> Vec<GpLeftOut> {
    let left_out = gp.leave_one_out();
    let count = gp.points() as f64;
    let mut rows = Vec::new();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let errors_m: Vec<f64> = gp
            .training_outputs()
            .iter()
            .zip(left_out.mean.iter())
            .map(|(row, mean)| (row[axis] - mean[axis]).abs())
            .collect();
        let log_probability =
            left_out.log_probability.iter().map(|row| row[axis]).sum::<f64>() / count;
        for &promised in shares {
            // A normal error lies within ± this many standard deviations in the promised share of
            // cases.
            let quantile = normal_quantile(0.5 + 0.5 * promised);
            let inside =
                |(error_m, variance): (&f64, &[f64])| *error_m <= quantile * variance[axis].sqrt();
            let covered =
                errors_m.iter().zip(left_out.variance.iter()).filter(|pair| inside(*pair)).count();
            rows.push(GpLeftOut {
                points: gp.points() as u64,
                kernel: gp.config().kernel.name().to_owned(),
                axis: name.to_owned(),
                mae_m: errors_m.iter().sum::<f64>() / count,
                log_probability,
                promised,
                covered: covered as f64 / count,
            });
        }
    }
    rows
}
