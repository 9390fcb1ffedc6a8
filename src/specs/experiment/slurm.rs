//! What an experiment asks of a Slurm cluster. Results do not depend on it.

use crate::base::BadOption;
use serde::{Deserialize, Serialize};

/// Shortest limit, minutes: the notice comes 90 s before, and clusters round that up by as much as
/// a minute.
const MIN_TIME_MIN: u32 = 4;

/// Resources and place of a worker. The cluster sets omitted values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SlurmOptions {
    /// Partition.
    pub partition: Option<String>,
    /// Account to charge.
    pub account: Option<String>,
    /// Time limit of a worker, minutes. Ninety seconds before the limit it completes its current
    /// stages and ends.
    pub time_min: Option<u32>,
    /// Memory of a worker, megabytes.
    pub memory_mb: Option<u32>,
    /// Processors, and threads, of a worker.
    pub cpus: u32,
    /// Workers that each task of the job array starts at once; by default the number that limits
    /// the array to a hundred tasks.
    pub workers_per_task: Option<u32>,
    /// Number of resubmissions of workers without new results.
    pub attempts: u32,
    /// Further arguments of `sbatch`.
    pub arguments: Vec<String>,
    /// No effect: workers take single stages. Accepted for older specs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task_s: Option<f64>,
}

impl Default for SlurmOptions {
    fn default() -> Self {
        SlurmOptions {
            partition: None,
            account: None,
            time_min: None,
            memory_mb: None,
            cpus: 1,
            workers_per_task: None,
            attempts: 3,
            arguments: Vec::new(),
            task_s: None,
        }
    }
}

impl SlurmOptions {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        if let Some(minutes) = self.time_min.filter(|&minutes| minutes < MIN_TIME_MIN) {
            let expected =
                "at least 4: the notice comes up to two and a half minutes before the end";
            return Err(BadOption { key: "time_min", found: minutes.to_string(), expected });
        }
        BadOption::unless_counted("cpus", self.cpus as usize)?;
        BadOption::unless_counted("workers_per_task", self.workers_per_task.unwrap_or(1) as usize)?;
        BadOption::unless_counted("attempts", self.attempts as usize)
    }
}
