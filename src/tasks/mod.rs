//! Control loops: exploration, replay, goal reaching, path tracking, and recording of commands.

mod displaced_rod;
mod learning_data;
mod loops;
mod monitor;
mod record;
mod scenes;
mod simulate;
mod tip_model;
mod transitions;

pub use learning_data::corrected_samples::correct_samples;
pub use learning_data::imitation::{ReachedPose, imitate, reached_poses};
pub use learning_data::rollout::rollout;
pub use loops::pace::{Lap, LapTimes, lap};
pub use loops::reach::{LoopMode, ReachOptions, ReachOutcome, reach};
pub use loops::response::{Response, ResponseLimits, response};
pub use loops::track::{TrackOptions, TrackStep, track};
pub use loops::watched::WatchedRobot;
pub use loops::work::Work;
pub use monitor::{Monitor, MonitorOptions, MonitorState};
pub use record::actuation::{BendMap, GridOptions};
pub use record::explore::{ExploreOptions, explore, explore_trajectory, replay, replay_trajectory};
pub use record::gp_points::{
    GpPoints, GpPointsOptions, GpPool, PointLayout, SimulatedBy, gp_points,
};
pub use record::path::{PathOptions, interpolate, waypoints};
pub use record::policy_samples::policy_samples;
pub use record::record_trial::{UnevenSteps, record_trial, step_s};
pub use record::static_poses::{StaticPoseOptions, plan_static_poses, record_static_poses, star_m};
pub use record::targets::{TargetOptions, draw_targets, spread_targets, target_pool};
pub use scenes::recorded::{scene_of_measurement, scene_of_recording};
pub use scenes::robot_shape::{scene_frame, scene_robot, tracked_at_stations};
pub use simulate::robot_recordings::{
    are_at_rest, check_one_gravity, of_tendons, read_commands, read_to_calibrate, read_to_explain,
};
pub use simulate::simulate_recording::{
    RecordingWithRates, simulate_recording, simulate_with_rates,
};
pub use simulate::simulated_columns::TOUCHES_ITSELF;
pub use simulate::simulated_trial::SimulationOptions;
pub use tip_model::{has_tip_model, tip_model};
pub use transitions::Transitions;

use crate::base::{BadOption, PlantError, PolicyError};

/// Why a task failed. (A failed trial is a status of its outcome instead.)
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TaskError {
    /// The plant refused a command or failed.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// A learned model failed.
    #[error(transparent)]
    Model(#[from] PolicyError),
    /// A setting is out of range.
    #[error(transparent)]
    Option(#[from] BadOption),
    /// A model returned a number that is not finite.
    #[error("not finite: {0}")]
    NotFinite(&'static str),
    /// More was requested than is available.
    #[error("{what}: found {available}, expected at least {required}")]
    TooFew {
        /// What was requested.
        what: &'static str,
        /// Number requested.
        required: usize,
        /// Number available.
        available: usize,
    },
}
