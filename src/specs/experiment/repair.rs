//! Repair: what changes on a robot that works, how it is noticed, told and mended, and what is run
//! before and after.

use super::spec::ReachSweep;
use crate::discovery::Options;
use crate::effects::EffectSpec;
use crate::tasks::MonitorOptions;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A robot works under a monitor. `discover` has told from a recording what the model lacks of it
/// as it was built. Something changes that nobody announces; the monitor tells it, a recording is
/// made, `discover` names the change, the model gets the lines, and networks are trained on from
/// where they are.
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
    /// Options of the discovery of what has changed.
    #[serde(default)]
    pub discovery: Options,
    /// What else holds for the discovery of what the model lacks of the robot as it was built.
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

/// Many small effects rather than a few that stand for them: a change is told beside what is left
/// of the robot as it was built.
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
    /// Rows of a trial; each holds a measured tip, the first that at home.
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
