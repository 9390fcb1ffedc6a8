//! Repair: what changes on a robot that works, how it is noticed, told and mended, and what is run before and after.

use super::spec::ReachSweep;
use crate::discovery::Options;
use crate::effects::EffectSpec;
use crate::tasks::{MonitorOptions, RecordedMotion};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A robot works under a monitor. `discover` has told from a recording what the model lacks of it as it was built. Something
/// changes that nobody announces; the monitor tells it, a recording is made, `discover` names the change, the model gets the
/// lines, and networks are trained on from where they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RepairRun {
    /// What changes: the effects that the robot gets, by the name of the change.
    pub changes: BTreeMap<String, Vec<EffectSpec>>,
    /// The policy that works, in closed loop.
    #[serde(default = "worker")]
    pub worker: String,
    /// Real points of the error model of the working policy and of the monitor.
    #[serde(default = "gp_points")]
    pub gp_points: usize,
    /// Real points of the working policy's network, where it is trained on such.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub real_points: Option<usize>,
    /// The recordings.
    #[serde(default)]
    pub recordings: RepairRecordings,
    /// The work and its monitor.
    #[serde(default)]
    pub monitor: MonitorOptions,
    /// Options of the discovery.
    #[serde(default)]
    pub discovery: Options,
    /// Goal reaching before the change, after it, and repaired: products of policies, modes and sizes.
    pub cells: Vec<ReachSweep>,
}

/// The paper's first policy.
fn worker() -> String {
    "a".to_owned()
}

/// The paper's number of real points.
fn gp_points() -> usize {
    100
}

/// The recordings; each trial begins at home, steps and pulls are limited as those of `explore`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RepairRecordings {
    /// The commands.
    pub motion: RecordedMotion,
    /// Rows of a trial; each holds a measured tip, the first that at home.
    pub rows: usize,
    /// Trials of the robot as it was built.
    pub trials_before: usize,
    /// Trials of the changed robot.
    pub trials_after: usize,
}

impl Default for RepairRecordings {
    fn default() -> Self {
        RepairRecordings { motion: RecordedMotion::Walk, rows: 20, trials_before: 15, trials_after: 5 }
    }
}
