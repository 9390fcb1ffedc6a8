//! The learned models as the parts of policies.

use std::sync::{Arc, Mutex, PoisonError};

use super::model_traits::{ErrorModel, ForwardModel, InverseModel, LearningErrorModel};
use crate::base::{Displacements, Point3, PolicyError};
use crate::learn::LearnError;
use crate::learn::gp::{Gp, Leaving, OnlineGp};
use crate::learn::networks::{Network, NetworkState};

/// A network trained on (x_i, x_{i+1}) → u_i (eq. 21): six inputs, one output a tendon. The weights
/// are shared, the memory is its own.
pub struct NetworkInverse {
    network: Arc<Network>,
    /// Memory as of the last tick.
    memory: NetworkState,
    /// Memory after the last question.
    next: NetworkState,
}

impl NetworkInverse {
    /// The network at rest.
    ///
    /// # Errors
    /// [`LearnError::Shape`] for a network that does not take two positions.
    pub fn new(network: Arc<Network>) -> Result<Self, LearnError> {
        LearnError::unless_shape(
            "inputs of an inverse mapping (two positions)",
            network.inputs(),
            6,
        )?;
        let state = network.state();
        Ok(NetworkInverse { network, memory: state.clone(), next: state })
    }
}

impl InverseModel for NetworkInverse {
    fn reset(&mut self) {
        self.memory.reset();
        self.next.reset();
    }

    fn pulls(&mut self, from_m: &Point3, to_m: &Point3) -> Result<Displacements, PolicyError> {
        let [x, y, z] = *from_m;
        let [to_x, to_y, to_z] = *to_m;
        let mut pulls_m = vec![0.0; self.network.outputs()];
        self.next.clone_from(&self.memory);
        self.network
            .step(&mut self.next, &[x, y, z, to_x, to_y, to_z], &mut pulls_m)
            .map_err(|_| PolicyError::NotFinite("input of the inverse network"))?;
        Ok(pulls_m)
    }

    fn tick(&mut self) {
        self.memory.clone_from(&self.next);
    }
}

/// A network trained on (u_i, x_i) → x_{i+1} (eq. 17), run freely: what it predicted is its next
/// x_i.
pub struct NetworkForward {
    network: Arc<Network>,
    memory: NetworkState,
    tip_m: Point3,
}

impl NetworkForward {
    /// The network at rest.
    ///
    /// # Errors
    /// [`LearnError::Shape`] for a network that does not go from displacements and a position to a
    /// position.
    pub fn new(network: Arc<Network>, tendons: usize) -> Result<Self, LearnError> {
        let what = "inputs of a forward model (displacements and a position)";
        LearnError::unless_shape(what, network.inputs(), tendons + 3)?;
        LearnError::unless_shape("outputs of a forward model", network.outputs(), 3)?;
        Ok(NetworkForward { memory: network.state(), network, tip_m: [0.0; 3] })
    }
}

impl ForwardModel for NetworkForward {
    fn reset(&mut self, home_m: &Point3) {
        self.memory.reset();
        self.tip_m = *home_m;
    }

    fn next_m(&mut self, pulls_m: &[f64]) -> Result<Point3, PolicyError> {
        let input = [pulls_m, self.tip_m.as_slice()].concat();
        let mut next_m = [0.0; 3];
        self.network
            .step(&mut self.memory, &input, &mut next_m)
            .map_err(|_| PolicyError::NotFinite("input of the forward network"))?;
        PolicyError::unless_finite("output of the forward network", &next_m)?;
        self.tip_m = next_m;
        Ok(next_m)
    }
}

/// A Gaussian process fitted to (L_1 … L_n, p_sim) → p_sim − p_exp (eq. 20).
pub struct GpError(Gp);

impl GpError {
    /// The error model of a robot with `tendons` tendons.
    ///
    /// # Errors
    /// [`LearnError::Shape`] for a process that does not go from displacements and a position to a
    /// position.
    pub fn new(gp: Gp, tendons: usize) -> Result<Self, LearnError> {
        let what = "inputs of an error model (displacements and a position)";
        LearnError::unless_shape(what, gp.inputs(), tendons + 3)?;
        LearnError::unless_shape("outputs of an error model", gp.outputs(), 3)?;
        Ok(GpError(gp))
    }
}

impl ErrorModel for GpError {
    /// The predicted mean (section IV-B); not a number for another number of tendons than it was
    /// made for.
    fn error_m(&self, pulls_m: &[f64], p_sim_m: &Point3) -> Point3 {
        let input = [pulls_m, p_sim_m.as_slice()].concat();
        point(self.0.mean(&input))
    }

    fn learning(&self, points: usize, leaves: Leaving) -> Option<Arc<dyn LearningErrorModel>> {
        Some(Arc::new(LearningGpError(Mutex::new(OnlineGp::new(&self.0, points, leaves).ok()?))))
    }
}

fn point(mean: Result<Vec<f64>, LearnError>) -> Point3 {
    mean.ok().and_then(|mean| mean.try_into().ok()).unwrap_or([f64::NAN; 3])
}

/// The same with the points of a trial. A lock, because policies share error models between
/// threads.
struct LearningGpError(Mutex<OnlineGp>);

impl ErrorModel for LearningGpError {
    fn error_m(&self, pulls_m: &[f64], p_sim_m: &Point3) -> Point3 {
        let input = [pulls_m, p_sim_m.as_slice()].concat();
        point(self.0.lock().unwrap_or_else(PoisonError::into_inner).mean(&input))
    }
}

impl LearningErrorModel for LearningGpError {
    fn measured(
        &self,
        pulls_m: &[f64],
        p_sim_m: &Point3,
        tip_m: &Point3,
    ) -> Result<(), PolicyError> {
        let input = [pulls_m, p_sim_m.as_slice()].concat();
        let error_m: Point3 = std::array::from_fn(|axis| p_sim_m[axis] - tip_m[axis]);
        let mut gp = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        gp.add(&input, &error_m)
            .map_err(|_| PolicyError::NotFinite("measured point of the error model"))
    }

    fn restart(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).restart();
    }
}
