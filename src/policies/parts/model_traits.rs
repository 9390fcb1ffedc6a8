//! What a policy asks of a learned model. The registry of policies stands elsewhere, so that a new
//! policy does not count as a change of the stages that train networks.

use std::sync::Arc;

use crate::base::{Displacements, Point3, PolicyError};
use crate::learn::gp::Leaving;

/// A learned inverse mapping (x_i, x_target) → u_i, eq. (22): a recurrent network with a memory.
///
/// Within one control tick `pulls` may be asked several times (an optimisation does); the memory
/// stays as it was at the tick's start until [`InverseModel::tick`] says that time has passed.
///
/// ```
/// use spinebench::base::{Displacements, Point3, PolicyError};
/// use spinebench::policies::InverseModel;
///
/// struct Proportional;
/// impl InverseModel for Proportional {
///     fn reset(&mut self) {}
///     fn pulls(&mut self, _from_m: &Point3, to_m: &Point3) -> Result<Displacements, PolicyError> {
///         Ok(vec![0.2 * to_m[0], 0.2 * to_m[1], -0.2 * to_m[0], -0.2 * to_m[1]])
///     }
/// }
/// ```
pub trait InverseModel: Send {
    /// Forgets everything (the robot is at rest at home).
    fn reset(&mut self);
    /// Displacements in metres that take the tip from `from_m` to `to_m` in one step.
    ///
    /// # Errors
    /// [`PolicyError`] when an input or an output is not finite.
    fn pulls(&mut self, from_m: &Point3, to_m: &Point3) -> Result<Displacements, PolicyError>;
    /// A control tick has passed: what the last `pulls` saw becomes memory. Models without memory
    /// do nothing.
    fn tick(&mut self) {}
}

/// A learned forward model (u_i, x_i) → x_{i+1}, eq. (17): it moves on by itself, from its own last
/// prediction.
pub trait ForwardModel: Send {
    /// The robot is at rest at home, where the tip is `home_m`.
    fn reset(&mut self, home_m: &Point3);
    /// The predicted tip after a step under `pulls_m`, metres.
    ///
    /// # Errors
    /// [`PolicyError`] when an input or an output is not finite.
    fn next_m(&mut self, pulls_m: &[f64]) -> Result<Point3, PolicyError>;
}

/// A learned model of the gap, eq. (20): e = p_sim − p_exp.
pub trait ErrorModel: Send + Sync {
    /// Predicted `p_sim − p_exp` in metres for displacements (metres) and a simulated tip (metres).
    fn error_m(&self, pulls_m: &[f64], p_sim_m: &Point3) -> Point3;
    /// A copy that learns from measurements, with at most `points` of them; `None` for a model that
    /// cannot.
    fn learning(&self, _points: usize, _leaves: Leaving) -> Option<Arc<dyn LearningErrorModel>> {
        None
    }
}

/// An error model that learns while it is used.
pub trait LearningErrorModel: ErrorModel {
    /// Under the displacements `pulls_m` the tip was measured at `tip_m`, where the simulated one
    /// is `p_sim_m`; metres.
    ///
    /// # Errors
    /// [`PolicyError`] when a number is not finite.
    fn measured(
        &self,
        pulls_m: &[f64],
        p_sim_m: &Point3,
        tip_m: &Point3,
    ) -> Result<(), PolicyError>;
    /// Forgets what was measured.
    fn restart(&self);
}
