//! What networks and Gaussian processes are trained on.

use crate::base::Rows;
use crate::learn::rnn::Trained;
use crate::policies::ElmanForward;
use crate::tasks::{self, Transitions};
use std::sync::Arc;

/// The commands of a recording as the forward network plays them.
pub(super) fn simulated(network: &Trained, samples: &Transitions) -> Result<Transitions, String> {
    let network = Arc::new(network.network.clone());
    let mut model = ElmanForward::new(network, samples.pulls_m.width()).map_err(|error| error.to_string())?;
    tasks::rollout(samples, &mut model).map_err(|error| error.to_string())
}

/// The columns of two tables side by side.
pub(super) fn joined(left: &Rows, right: &Rows) -> Rows {
    let mut rows = Rows::new(left.width() + right.width());
    for (left, right) in left.iter().zip(right.iter()) {
        rows.push(&[left, right].concat());
    }
    rows
}
