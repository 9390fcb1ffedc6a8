//! What was learnt, in the shape in which policies take it.

use crate::base::{Displacements, Point3, PolicyError};
use crate::learn::gp::Gp;
use crate::learn::rnn::{Elman, ElmanState};
use crate::policies::{ErrorModel, InverseModel};
use std::sync::Arc;

/// A trained inverse network as policies ask it.
pub(super) fn inverse_model(network: Elman) -> Box<dyn InverseModel> {
    let state = network.state();
    Box::new(NetworkInverse { asked: state.clone(), state, network })
}

/// A Gaussian process of eq. (20) as policies ask it.
pub(super) fn error_model(gp: Gp) -> Arc<dyn ErrorModel> {
    Arc::new(GpError(gp))
}

struct NetworkInverse {
    network: Elman,
    /// The memory at the start of the tick.
    state: ElmanState,
    /// What the last question made of it.
    asked: ElmanState,
}

impl InverseModel for NetworkInverse {
    fn reset(&mut self) {
        self.state.reset();
        self.asked.reset();
    }

    fn pulls(&mut self, from_m: &Point3, to_m: &Point3) -> Result<Displacements, PolicyError> {
        let input: Vec<f64> = from_m.iter().chain(to_m).copied().collect();
        let mut pulls_m = vec![0.0; self.network.outputs()];
        self.asked.clone_from(&self.state);
        let step = self.network.step(&mut self.asked, &input, &mut pulls_m);
        step.map_err(|_| PolicyError::NotFinite("input of the inverse network"))?;
        Ok(pulls_m)
    }

    fn tick(&mut self) {
        self.state.clone_from(&self.asked);
    }
}

struct GpError(Gp);

impl ErrorModel for GpError {
    fn error_m(&self, pulls_m: &[f64], p_sim_m: &Point3) -> Point3 {
        let input: Vec<f64> = pulls_m.iter().chain(p_sim_m).copied().collect();
        // A query that is not finite has no answer; the policy then names what was not finite.
        let mean = self.0.mean(&input).unwrap_or_default();
        std::array::from_fn(|axis| mean.get(axis).copied().unwrap_or(f64::NAN))
    }
}
