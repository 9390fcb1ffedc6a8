//! Samples that networks are trained on.

pub(super) mod corrected_samples;
pub(super) mod imitation;
pub(super) mod rollout;
