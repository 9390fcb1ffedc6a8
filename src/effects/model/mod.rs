//! A model file: the robot, its effects, obstacles, drives and tracked points, and its parameters.

pub(super) mod obstacles;
pub(super) mod parameter;
pub(super) mod robot_model;
pub(super) mod tendon_drive;
pub(super) mod tracking;
