//! What stages compute. A job sees its parameters and the results of its inputs, nothing else.
//!
//! The key of a stage holds a digest of the sources that its file here imports, through any number
//! of files (`build/import_graph.rs`). So stages that depend on different code stand in different
//! files, and a file here imports narrow types: an experiment as a whole would bring all of
//! `specs`.

pub(super) mod data;
pub(super) mod discovery;
pub(super) mod learning;
pub(super) mod parts;
pub(super) mod repair;
pub(super) mod trials;

use super::graph::stage::StageKind;
use data::{
    exploration::{EXPLORE, REPLAY},
    gap::GAP,
    gp_pool::GP_POOL,
    path::{PATH, WAYPOINTS},
    targets::{TARGET_POOL, TARGETS},
};
use discovery::{
    baselines::{BASELINES, BASELINES_RECORDED},
    blind::{COMMANDS, RECORDED_TRUTH, RECORDING, SPAN, TRUTH},
    blind_score::SCORE,
    discover::{DISCOVER, DISCOVER_RECORDED},
};
use learning::{
    gaussian_process::{GP, GP_SCORE},
    gp_coverage::GP_COVERAGE,
    gp_leave_one_out::GP_LEAVE_ONE_OUT,
};
use repair::{
    diagnose::{DIAGNOSE, IDENTIFY},
    gp_repaired::{GP_MOVED, GP_REPAIRED},
    nearest::NEAREST,
    repaired::EXPLORE_REPAIRED,
    retrain::RETRAIN,
    work::{ALARM, MONITOR},
};
use trials::{
    reach_track::{REACH, TRACK},
    responses::{PACE, RESPONSE},
};

/// Every kind of stage but the training of networks, which policies describe.
pub(super) fn kinds() -> Vec<StageKind> {
    let mut kinds = vec![EXPLORE.kind, REPLAY.kind, GAP.kind, GP_POOL.kind];
    kinds.extend([TARGET_POOL.kind, TARGETS.kind, WAYPOINTS.kind, PATH.kind]);
    kinds.extend([GP.kind, GP_SCORE.kind, GP_COVERAGE.kind]);
    kinds.extend([GP_LEAVE_ONE_OUT.kind]);
    kinds.extend([REACH.kind, TRACK.kind, RESPONSE.kind, PACE.kind]);
    kinds.extend([MONITOR.kind, ALARM.kind, DIAGNOSE.kind, IDENTIFY.kind]);
    kinds.extend([EXPLORE_REPAIRED.kind, GP_REPAIRED.kind, GP_MOVED.kind]);
    kinds.extend([RETRAIN.kind, NEAREST.kind]);
    kinds.extend([COMMANDS.kind, SPAN.kind, TRUTH.kind, RECORDING.kind]);
    kinds.extend([DISCOVER.kind, SCORE.kind]);
    kinds.extend([DISCOVER_RECORDED.kind, RECORDED_TRUTH.kind]);
    kinds.extend([BASELINES.kind, BASELINES_RECORDED.kind]);
    kinds
}
