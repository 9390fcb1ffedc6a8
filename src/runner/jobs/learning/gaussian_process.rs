//! The Gaussian process of the gap between model and robot.

use crate::base::Seed;
use crate::learn::gp::{Gp, GpConfig};
use crate::learn::networks::Trained;
use crate::rows::experiment::GpScore;
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::data::samples::points;
use crate::tasks::{GpPoints, GpPool};

/// Handles of the predefined points, and of the forward network where p_sim comes from it.
pub(crate) type GpInputs = (Handle<GpPool>, Option<Handle<Trained>>);

/// The process of eq. (20) on `points` of the predefined points.
pub(crate) const GP: Stage<GpParams, GpInputs, Gp> = Stage {
    kind: StageKind { name: "gp_fit", module: module_path!(), cost_ms: 100 },
    job: |params, (pool, network)| {
        let all = points(pool, network)?;
        params.fit(&all.select(&params.chosen(&all)?))
    },
};

/// How well the process fits: a stage of its own, so that publishing holds no process in memory.
pub(crate) const GP_SCORE: Stage<(), Handle<Gp>, GpScore> = Stage {
    kind: StageKind { name: "gp_score", module: module_path!(), cost_ms: 50 },
    job: |(), gp| Ok(score(gp)),
};

/// Parameters of [`GP`].
#[derive(serde::Serialize)]
pub(crate) struct GpParams {
    pub(crate) config: GpConfig,
    pub(crate) points: usize,
    pub(crate) seed: u64,
}

impl GpParams {
    /// The indices of the points that the process is fitted to.
    pub(crate) fn chosen(&self, all: &GpPoints) -> Result<Vec<usize>, String> {
        let chosen = self.config.selection.choose(&all.inputs, self.points, Seed(self.seed));
        chosen.map_err(|error| error.to_string())
    }

    /// The process of these points.
    pub(crate) fn fit(&self, points: &GpPoints) -> Result<Gp, String> {
        Gp::fit(&points.inputs, &points.errors_m, &self.config).map_err(|error| error.to_string())
    }
}

/// The hyper-parameters at an end of their range, by axis.
fn at_range_end(gp: &Gp) -> String {
    let ends = gp.range_ends();
    let texts = ends.iter().map(|end| {
        let axis = ["x", "y", "z"].get(end.output).copied().unwrap_or("");
        format!("{axis} {}", end.describe())
    });
    texts.collect::<Vec<String>>().join("; ")
}

fn score(gp: &Gp) -> GpScore {
    let noise = gp.noise_std();
    let noise_m = |axis: usize| noise.get(axis).copied().unwrap_or(f64::NAN);
    GpScore {
        points: gp.points() as u64,
        kernel: gp.config().kernel.name().to_owned(),
        cross_validation_mae_m: crate::math::summary::mean(&gp.cross_validation_mae()),
        log_marginal_likelihood: gp.log_marginal_likelihood().iter().sum(),
        noise_x_m: noise_m(0),
        noise_y_m: noise_m(1),
        noise_z_m: noise_m(2),
        at_range_end: at_range_end(gp),
    }
}
