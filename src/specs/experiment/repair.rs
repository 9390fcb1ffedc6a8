//! Repair: what changes on a robot that works, how it is noticed, told and mended, and what is run
//! before and after.

use super::spec::ReachSweep;
use crate::discovery::Options;
use crate::effects::EffectSpec;
use crate::tasks::MonitorOptions;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A robot works under a monitor. `discover` has identified from a recording what the model lacks
/// of the robot as built. An unannounced change occurs; the monitor detects it, a recording is
/// made, `discover` identifies the change, the model is extended by the named lines, and the
/// networks are trained further.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RepairRun {
    /// The changes by name: effects added to the robot.
    pub changes: BTreeMap<String, Vec<EffectSpec>>,
    /// The policy that works, in closed loop.
    #[serde(default = "worker")]
    pub worker: String,
    /// Real points of the error model of the working policy and of the monitor.
    #[serde(default = "gp_points")]
    pub gp_points: usize,
    /// Real points of the working policy's network, if it is trained on real points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub real_points: Option<usize>,
    /// The recordings.
    #[serde(default)]
    pub recordings: RepairRecordings,
    /// The work and its monitor.
    #[serde(default)]
    pub monitor: MonitorOptions,
    /// Options of the discovery of the change.
    #[serde(default)]
    pub discovery: Options,
    /// Further options of the discovery of what the model lacks of the robot as built.
    #[serde(default)]
    pub identification: Identification,
    /// Goal reaching before the change, after it, and repaired: products of policies, modes and
    /// sizes.
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

impl RepairRun {
    /// Options of the discovery of what the model lacks of the robot as it was built.
    pub fn identification_options(&self) -> Options {
        let Identification { most_effects, least_share } = self.identification;
        Options { most_effects, least_share, ..self.discovery.clone() }
    }
}

/// Many small effects instead of a few that represent them, because the change is identified
/// against the remaining residual of the robot as built.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Identification {
    /// As `discovery.most_effects`.
    pub most_effects: usize,
    /// As `discovery.least_share`.
    pub least_share: f64,
}

impl Default for Identification {
    fn default() -> Self {
        Identification { most_effects: 6, least_share: 0.01 }
    }
}

/// The recordings: random walks from home, as those of `explore`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RepairRecordings {
    /// Rows of a trial; each contains a measured tip, the first one at home.
    pub rows: usize,
    /// Trials of the robot as it was built.
    pub trials_before: usize,
    /// Trials of the changed robot.
    pub trials_after: usize,
}

impl Default for RepairRecordings {
    fn default() -> Self {
        RepairRecordings { rows: 20, trials_before: 15, trials_after: 5 }
    }
}
