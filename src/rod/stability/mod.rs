//! Loss of stability: of equilibria and of motions (docs/method/robustness.md).

pub(crate) mod bound;
pub(crate) mod linearised_motion;
pub(crate) mod perturbation;
pub(crate) mod tangent;
