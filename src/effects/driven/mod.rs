//! A model driven by commands: its drives, its observations and their derivatives.

pub(super) mod drive_path;
pub(super) mod driven_model;
pub(super) mod perturbation;
pub(super) mod replay;
