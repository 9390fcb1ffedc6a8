//! What a controller may ask of a model of the robot. The model is the nominal one: nothing of the
//! robot itself stands behind it.

use super::observation::{Displacements, Point3};

/// The model has no pose at rest under a bend; holds its reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("model of the robot: {0}")]
pub struct NoRestPose(pub String);

/// The pose of a model at rest under a bend.
#[derive(Clone, Debug, PartialEq)]
pub struct RestPose {
    /// Displacement of each tendon, metres.
    pub pulls_m: Displacements,
    /// The tip, metres.
    pub tip_m: Point3,
}

/// A model that predicts where the tip comes to rest.
///
/// A bend is two numbers for each segment from base to tip, towards x and towards y, metres: about
/// the displacement of a tendon that lies there. It says how the tendons are loaded; the
/// displacements that this takes are part of the pose.
pub trait TipModel: Send {
    /// Number of components of a bend.
    fn bends(&self) -> usize;

    /// Forgets earlier questions: a trial does not depend on those before it, not even in the last
    /// digit.
    fn restart(&mut self) {}

    /// The pose at rest under a bend: tendons on its side are pulled, the others follow without
    /// slack and without tension.
    ///
    /// # Errors
    /// [`NoRestPose`] where the model has no equilibrium.
    fn at_rest(&mut self, bend_m: &[f64]) -> Result<RestPose, NoRestPose>;

    /// Derivative of that tip with respect to each component of the bend, metres per metre.
    ///
    /// # Errors
    /// [`NoRestPose`] where the model has no equilibrium, or one at which the derivative does not
    /// exist.
    fn tip_per_bend(&mut self, bend_m: &[f64]) -> Result<Vec<Point3>, NoRestPose>;
}
