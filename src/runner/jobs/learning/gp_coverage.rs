//! How often the intervals of the Gaussian process hold what they promise, on predefined points
//! that it has not seen.

use super::gaussian_process::GpParams;
use crate::learn::gp::Gp;
use crate::learn::networks::Trained;
use crate::math::distribution::normal_quantile;
use crate::rows::experiment::GpCoverage;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::data::samples::points;
use crate::tasks::GpPool;

/// Handles of the predefined points, of the forward network where p_sim comes from it, and of the
/// process.
pub(crate) type CoverageInputs = (Handle<GpPool>, Option<Handle<Trained>>, Handle<Gp>);

/// By axis and promised share.
pub(crate) const GP_COVERAGE: Stage<CoverageParams, CoverageInputs, Vec<GpCoverage>> = Stage {
    kind: StageKind { name: "gp_coverage", module: module_path!(), cost_ms: 50 },
    job: |params, (pool, network, gp)| {
        let all = points(pool, network)?;
        let chosen = params.gp.chosen(&all)?;
        let unseen_indices: Vec<usize> =
            (0..all.inputs.len()).filter(|index| chosen.binary_search(index).is_err()).collect();
        let unseen = all.select(&unseen_indices);
        let predicted = gp.predict_rows(&unseen.inputs).map_err(|error| error.to_string())?;
        let noise_m = gp.noise_std();
        let mut rows = Vec::new();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            // In standard deviations of what would be measured: of the gap and of the noise.
            let deviations: Vec<f64> = (0..unseen_indices.len())
                .map(|row| {
                    let error_m = unseen.errors_m.row(row)[axis] - predicted.mean.row(row)[axis];
                    error_m.abs()
                        / (predicted.variance.row(row)[axis] + noise_m[axis].powi(2)).sqrt()
                })
                .collect();
            for &promised in &params.shares {
                // A normal error lies within ± this many standard deviations in the promised share
                // of cases.
                let quantile = normal_quantile(0.5 + 0.5 * promised);
                let covered = deviations.iter().filter(|deviation| **deviation <= quantile).count();
                rows.push(GpCoverage {
                    points: params.gp.points as u64,
                    kernel: params.gp.config.kernel.name().to_owned(),
                    axis: name.to_owned(),
                    promised,
                    covered: covered as f64 / unseen_indices.len() as f64,
                    unseen: unseen_indices.len() as u64,
                });
            }
        }
        Ok(rows)
    },
};

/// Parameters of [`GP_COVERAGE`].
#[derive(serde::Serialize)]
pub(crate) struct CoverageParams {
    pub(crate) gp: GpParams,
    /// Promised shares, above 0 and below 1.
    pub(crate) shares: Vec<f64>,
}
