//! What is recorded on a robot: exploration, predefined points, poses at rest, targets, the path,
//! samples that a policy chooses.

pub(super) mod actuation;
pub(super) mod explore;
pub(super) mod gp_points;
pub(super) mod path;
pub(super) mod policy_samples;
pub(super) mod record_trial;
pub(super) mod retry_lost_frames;
pub(super) mod static_poses;
pub(super) mod targets;
