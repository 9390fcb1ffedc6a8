//! What networks and Gaussian processes are trained on.

use crate::base::Rows;
use crate::learn::networks::Trained;
use crate::policies::NetworkForward;
use crate::tasks::{self, GpPoints, GpPool, Transitions};
use std::sync::Arc;

/// The commands of a recording as the forward network plays them.
pub(crate) fn simulated(network: &Trained, samples: &Transitions) -> Result<Transitions, String> {
    let network = Arc::new(network.network.clone());
    let mut model =
        NetworkForward::new(network, samples.pulls_m.width()).map_err(|error| error.to_string())?;
    tasks::rollout(samples, &mut model).map_err(|error| error.to_string())
}

/// The predefined points, with p_sim from the forward network where there is one.
pub(crate) fn points(pool: &GpPool, network: Option<&Trained>) -> Result<GpPoints, String> {
    let simulated = network.map(|network| simulated(network, &pool.steps)).transpose()?;
    Ok(pool.points_by(simulated.as_ref().unwrap_or(&pool.steps)))
}

/// The columns of two tables side by side.
pub(crate) fn joined(left: &Rows, right: &Rows) -> Rows {
    let mut rows = Rows::new(left.width() + right.width());
    for (left, right) in left.iter().zip(right.iter()) {
        rows.push(&[left, right].concat());
    }
    rows
}
