//! Control loops: exploration, replay, goal reaching, path tracking, and recording of commands.

mod actuation;
mod body_lines;
mod corrected_samples;
mod explore;
mod gp_points;
mod imitation;
mod monitor;
mod pace;
mod path;
mod reach;
mod record;
mod response;
mod retry_lost_frames;
mod robot_recordings;
mod rollout;
mod simulate_recording;
mod simulated_columns;
mod simulated_trial;
mod static_poses;
mod targets;
mod tip_model;
mod track;
mod transitions;
mod watched;
mod work;

pub use actuation::{BendMap, GridOptions, bend_commands};
pub use body_lines::body_lines_m;
pub use corrected_samples::correct_samples;
pub use explore::{ExploreOptions, explore, explore_trajectory, replay, replay_trajectory};
pub use gp_points::{GpPoints, GpPointsOptions, GpPool, PointLayout, SimulatedBy, gp_points};
pub use imitation::{ReachedPose, imitate, reached_poses};
pub use monitor::{Monitor, MonitorOptions, MonitorState};
pub use pace::{Lap, lap};
pub use path::{PathOptions, interpolate, waypoints};
pub use reach::{LoopMode, ReachOptions, ReachOutcome, reach};
pub use record::{UnevenSteps, record_trial, step_s};
pub use response::{Response, response};
pub use robot_recordings::{check_one_gravity, check_tendons, read_commands, read_to_calibrate, read_to_explain};
pub use rollout::rollout;
pub use simulate_recording::{RecordingWithRates, SimulationOptions, simulate_recording, simulate_with_rates};
pub use simulated_columns::TOUCHES_ITSELF;
pub use static_poses::{StaticPoseOptions, plan_static_poses, record_static_poses, star_m};
pub use targets::{TargetOptions, draw_targets, spread_targets, target_pool};
pub use tip_model::{has_tip_model, tip_model};
pub use track::{TrackOptions, TrackStep, track};
pub use transitions::Transitions;
pub use watched::WatchedRobot;
pub use work::Work;

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
    #[error("{what}: found {available}, expected at least {asked}")]
    TooFew {
        /// What was requested.
        what: &'static str,
        /// Number requested.
        asked: usize,
        /// Number available.
        available: usize,
    },
}
