//! TODO

pub(super) mod obstacles;
pub(super) mod parameter;
pub(super) mod robot_model;
pub(super) mod tendon_drive;
pub(super) mod tracking;
