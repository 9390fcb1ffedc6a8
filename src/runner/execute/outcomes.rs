//! What became of the stages of a run.

use crate::runner::graph::stage::{AnyResult, StageResult};
use crate::runner::graph::timing::Timing;
use crate::runner::graph::{Failure, Handle};
use serde::{Deserialize, Serialize};

pub(crate) type StageOutcome = Result<AnyResult, Failure>;

/// What it cost a process that others worked at the same run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SharingCost {
    /// Stages that another process had stored when this one came to them.
    pub found: usize,
    /// Stages whose lock another process held.
    pub locks_lost: usize,
    /// Stages that another process stored while this one computed them.
    pub duplicates: usize,
    /// Time that this process spent on those, seconds.
    pub duplicate_s: f64,
    /// Times that a thread without work asked again for stages that other processes computed.
    pub polls: usize,
    /// Time that threads were without work, seconds.
    pub idle_s: f64,
    /// Stages that this process does not know to be done.
    pub left: usize,
}

/// What became of the stages that were wanted, and of those computed for them.
pub struct Outcomes {
    pub(crate) values: Vec<Option<StageOutcome>>,
    /// Time of each computed stage; `None` for those read from the store or not needed.
    pub timings: Vec<Option<Timing>>,
    /// Stages computed now.
    pub computed: usize,
    /// Stages read from the store.
    pub cached: usize,
    /// Failures of stages that were carried out, in the order of the graph.
    pub failures: Vec<Failure>,
    /// True when the run was told to stop before everything was done.
    pub stopped: bool,
    /// What it cost that others worked at the same run.
    pub sharing: SharingCost,
}

impl Outcomes {
    /// The result of a wanted stage.
    ///
    /// # Errors
    /// The failure of the stage or of one before it.
    pub fn get<T: StageResult>(&self, handle: Handle<T>) -> Result<&T, Failure> {
        let missing = || Failure {
            stage: "runner".into(),
            status: format!("stage {} was not requested", handle.node),
        };
        match self.values.get(handle.node).and_then(Option::as_ref) {
            Some(Ok(value)) => value.downcast_ref::<T>().ok_or_else(missing),
            Some(Err(failure)) => Err(failure.clone()),
            None => Err(missing()),
        }
    }

    /// The failure of stage number `node`, if it was carried out and failed.
    pub fn failure(&self, node: usize) -> Option<&Failure> {
        self.values.get(node)?.as_ref()?.as_ref().err()
    }

    pub(crate) fn new(
        values: Vec<Option<StageOutcome>>,
        timings: Vec<Option<Timing>>,
        cached: usize,
        stopped: bool,
        sharing: SharingCost,
    ) -> Self {
        let mut failures: Vec<Failure> = Vec::new();
        for failure in values.iter().filter_map(|value| value.as_ref()?.as_ref().err()) {
            failures.extend((!failures.contains(failure)).then(|| failure.clone()));
        }
        let computed = timings.iter().flatten().count();
        Outcomes { values, timings, computed, cached, failures, stopped, sharing }
    }
}
