//! Scenes of simulated robots for viewers.

pub(super) mod recorded;
pub(super) mod robot_shape;
