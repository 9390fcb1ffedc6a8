//! What stages compute. A job sees its parameters and the results of its inputs, nothing else.
//!
//! The key of a stage holds a digest of the sources that its file here imports, through any number of files
//! (`build/import_graph.rs`). So stages that depend on different code stand in different files, and a file here imports
//! narrow types: an experiment as a whole would bring all of `specs`.

pub(super) mod blind;
pub(super) mod blind_score;
pub(super) mod diagnose;
pub(super) mod diagnosis;
pub(super) mod discover;
pub(super) mod exploration;
pub(super) mod gap;
pub(super) mod gaussian_process;
pub(super) mod generated_network;
pub(super) mod gp_coverage;
pub(super) mod gp_leave_one_out;
pub(super) mod gp_pool;
pub(super) mod gp_repaired;
pub(super) mod identified;
pub(super) mod imitating_network;
pub(super) mod nearest;
pub(super) mod networks;
pub(super) mod outside_part;
pub(super) mod path;
pub(super) mod repaired;
pub(super) mod responses;
pub(super) mod retrain;
mod samples;
pub(super) mod shared_part;
pub(super) mod targets;
pub(super) mod trials;
pub(super) mod work;

use super::stage::StageKind;

/// Every kind of stage but the training of networks, which policies describe.
pub(super) fn kinds() -> Vec<StageKind> {
    let mut kinds = vec![exploration::EXPLORE.kind, exploration::REPLAY.kind, gap::GAP.kind, gp_pool::GP_POOL.kind];
    kinds.extend([targets::TARGET_POOL.kind, targets::TARGETS.kind, path::WAYPOINTS.kind, path::PATH.kind]);
    kinds.extend([gaussian_process::GP.kind, gaussian_process::GP_SCORE.kind, gp_coverage::GP_COVERAGE.kind]);
    kinds.extend([gp_leave_one_out::GP_LEAVE_ONE_OUT.kind]);
    kinds.extend([trials::REACH.kind, trials::TRACK.kind, responses::RESPONSE.kind, responses::PACE.kind]);
    kinds.extend([work::MONITOR.kind, work::ALARM.kind, diagnose::DIAGNOSE.kind, diagnose::IDENTIFY.kind]);
    kinds.extend([repaired::EXPLORE_REPAIRED.kind, gp_repaired::GP_REPAIRED.kind, gp_repaired::GP_MOVED.kind]);
    kinds.extend([retrain::RETRAIN.kind, nearest::NEAREST.kind]);
    kinds.extend([blind::COMMANDS.kind, blind::SPAN.kind, blind::TRUTH.kind, blind::RECORDING.kind]);
    kinds.extend([discover::DISCOVER.kind, blind_score::SCORE.kind]);
    kinds.extend([discover::DISCOVER_RECORDED.kind, blind::RECORDED_TRUTH.kind]);
    kinds
}
