//! What an experiment asks of a Slurm cluster. Results do not depend on it.

use crate::base::BadOption;
use serde::{Deserialize, Serialize};

/// Shortest limit of a task, minutes: it is told 90 s before, and clusters round that up by as much as a minute.
const LEAST_MIN: u32 = 4;

/// Resources of each task and where it runs. What is left out is for the cluster to decide.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SlurmOptions {
    /// Partition.
    pub partition: Option<String>,
    /// Account that is charged.
    pub account: Option<String>,
    /// Longest that a task may take, minutes. Ninety seconds before, it is told to end what it has begun.
    pub time_min: Option<u32>,
    /// Memory of a task, megabytes.
    pub memory_mb: Option<u32>,
    /// Processors of a task; its threads.
    pub cpus: u32,
    /// Stages are put together into tasks of about this length, seconds: short tasks cost the cluster more than they do.
    pub task_s: f64,
    /// Times that what got lost (a node that died, a limit that was reached) is submitted again without anything new
    /// having come of it.
    pub attempts: u32,
    /// Further arguments of `sbatch`.
    pub arguments: Vec<String>,
}

impl Default for SlurmOptions {
    fn default() -> Self {
        SlurmOptions {
            partition: None,
            account: None,
            time_min: None,
            memory_mb: None,
            cpus: 1,
            task_s: 60.0,
            attempts: 3,
            arguments: Vec::new(),
        }
    }
}

impl SlurmOptions {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("task_s", self.task_s)?;
        if let Some(minutes) = self.time_min.filter(|&minutes| minutes < LEAST_MIN) {
            let expected = "at least 4: the notice comes up to two and a half minutes before the end";
            return Err(BadOption { key: "time_min", found: minutes.to_string(), expected });
        }
        BadOption::unless_counted("cpus", self.cpus as usize)?;
        BadOption::unless_counted("attempts", self.attempts as usize)
    }
}
