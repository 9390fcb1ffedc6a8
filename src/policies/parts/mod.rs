//! What several policies share: learned models, the model at rest, limits of the drives, the tip.

pub(super) mod actuator_limits;
pub(super) mod bends;
pub(super) mod bounded_step;
pub(super) mod disturbance;
pub(super) mod horizon;
pub(super) mod inverse_network;
pub(super) mod learned;
pub(super) mod model_traits;
pub(super) mod models;
pub(super) mod network;
pub(super) mod policy_parts;
pub(super) mod rest_model;
pub(super) mod single_controller;
pub(super) mod tip_tracker;
