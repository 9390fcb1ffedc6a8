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
/// A bend is two numbers, towards x and towards y, metres: about the displacement of a tendon that
/// lies there. It says how the tendons are loaded; the displacements that this takes are part of
/// the pose. Where [`TipModel::takes_displacements`], as for a robot of several segments, a bend is
/// the displacement of each tendon.
pub trait TipModel: Send {
    /// Number of components of a bend.
    fn bends(&self) -> usize;

    /// Whether a bend is the displacement of each tendon.
    fn takes_displacements(&self) -> bool {
        false
    }

    /// Smallest distance of a tendon from the backbone, metres: its displacement where the robot
    /// bends by a radian.
    fn lever_m(&self) -> f64;

    /// Forgets earlier questions: a trial does not depend on those before it, not even in the last
    /// digit.
    fn restart(&mut self) {}

    /// The robot has had this bend as its command for `duration_s` seconds, or until it was at rest
    /// if that is infinite: where the model's tip is now. Poses of a model with memory go on from
    /// there. Nothing from a model that knows rest only.
    ///
    /// # Errors
    /// [`NoRestPose`] where the model cannot be moved on.
    fn follow(&mut self, _bend_m: &[f64], _duration_s: f64) -> Result<Option<Point3>, NoRestPose> {
        Ok(None)
    }

    /// The pose at rest under a bend: tendons on its side are pulled, the others follow without
    /// slack and without tension. A bend of displacements is where every drive stands.
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
