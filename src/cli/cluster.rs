//! Runs on a Slurm cluster: `run --executor slurm`, `status`, `cancel`, and what the tasks themselves call.

use super::shared::{CacheArgs, ProgressArgs};
use super::{CommandError, CommandResult};
use clap::Args;
use spinebench::runner::slurm::{self, Folder, Place, Watch, Worked};
use spinebench::runner::{Campaign, Failure, Key, Progress, Store};
use spinebench::specs::SlurmOptions;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

/// What is asked of the cluster; overrides the specs' `slurm:`.
#[derive(Args)]
#[command(next_help_heading = "Slurm")]
pub(super) struct Cluster {
    /// Partition.
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,
    /// Account that is charged.
    #[arg(long, value_name = "NAME")]
    account: Option<String>,
    /// Longest that a task may take, minutes.
    #[arg(long, value_name = "MINUTES")]
    time_min: Option<u32>,
    /// Memory of a task, megabytes.
    #[arg(long, value_name = "MEGABYTES")]
    memory_mb: Option<u32>,
    /// Processors of a task.
    #[arg(long, value_name = "N")]
    pub(super) cpus: Option<u32>,
    /// Length of a task that short stages are put together to, seconds.
    #[arg(long, value_name = "SECONDS")]
    task_s: Option<f64>,
    /// Submit and leave; the same command again comes back to it.
    #[arg(long)]
    detach: bool,
}

impl Cluster {
    /// Has the cluster fill the store; the stages that failed there, or nothing when somebody left before the end.
    pub(super) fn fill(
        &self,
        campaign: &Campaign,
        store: &Store,
        at_a_time: usize,
        progress: &Progress,
    ) -> Result<Option<HashMap<Key, Failure>>, CommandError> {
        let options = self.options(campaign)?;
        let root = std::path::absolute(store.root()).map_err(CommandError::failed)?;
        let store = Store::at(root);
        let watch = Watch { campaign, store: &store, options: &options, at_a_time, detach: self.detach, progress };
        match watch.run().map_err(CommandError::Failed)? {
            slurm::Ended::Done(failures) => Ok(Some(failures)),
            slurm::Ended::Cancelled => Err(CommandError::Failed(format!("campaign {} was cancelled", watch.id()))),
            slurm::Ended::Detached => {
                let id = watch.id();
                progress.say(&format!("the jobs go on; `spinebench status`, `spinebench cancel {id}`, or the same command again to come back and publish"));
                Ok(None)
            }
        }
    }

    /// The specs' options, which must agree, with what the command line says.
    fn options(&self, campaign: &Campaign) -> Result<SlurmOptions, CommandError> {
        let mut specs = campaign.entries.iter().map(|entry| &entry.experiment);
        let Some(first) = specs.next() else { return Ok(SlurmOptions::default()) };
        if let Some(other) = specs.find(|other| other.slurm != first.slurm) {
            let (one, other) = (&first.name, &other.name);
            let words = format!("slurm: found other settings in `{other}` than in `{one}`, expected the same");
            return Err(CommandError::BadInput(words));
        }
        let given = first.slurm.clone();
        let options = SlurmOptions {
            partition: self.partition.clone().or(given.partition),
            account: self.account.clone().or(given.account),
            time_min: self.time_min.or(given.time_min),
            memory_mb: self.memory_mb.or(given.memory_mb),
            cpus: self.cpus.unwrap_or(given.cpus),
            task_s: self.task_s.unwrap_or(given.task_s),
            ..given
        };
        let refuse = |bad: spinebench::base::BadOption| {
            let option = bad.key.replace('_', "-");
            CommandError::BadInput(format!("--{option}: found {}, expected {}", bad.found, bad.expected))
        };
        options.check().map_err(refuse)?;
        Ok(options)
    }
}

/// How the campaigns of a store stand that were submitted to a cluster.
#[derive(Args)]
pub(super) struct StatusCommand {
    #[command(flatten)]
    cache: CacheArgs,
}

impl StatusCommand {
    pub(super) fn execute(self) -> CommandResult {
        let mut text = String::new();
        for one in slurm::standing(&self.cache.store()) {
            let (id, names, done, all) = (&one.id, one.experiments.join(" "), one.done, one.stages);
            let failed = if one.failed > 0 { format!(", {} failed", one.failed) } else { String::new() };
            let off = if one.cancelled { ", cancelled" } else { "" };
            let _ = writeln!(text, "{id}  {names}: {done} of {all} stages{failed}{off}; {}", one.queue);
        }
        if text.is_empty() {
            text = "no campaigns\n".to_owned();
        }
        // A reader that has seen enough closes the pipe: no error.
        let _ = std::io::stdout().write_all(text.as_bytes());
        Ok(())
    }
}

/// Calls a campaign on a cluster off; what is stored stays.
#[derive(Args)]
pub(super) struct CancelCommand {
    /// Its name, as `status` tells it.
    #[arg(value_name = "CAMPAIGN")]
    id: String,
    #[command(flatten)]
    cache: CacheArgs,
}

impl CancelCommand {
    pub(super) fn execute(self) -> CommandResult {
        slurm::cancel(&self.cache.store(), &self.id).map_err(CommandError::BadInput)
    }
}

/// One task of a campaign, as the cluster begins it.
#[derive(Args)]
pub(super) struct WorkCommand {
    /// Folder of the campaign.
    folder: PathBuf,
    /// Number of the attempt.
    #[arg(long)]
    attempt: usize,
    /// Number of the wave.
    #[arg(long)]
    wave: usize,
    /// Number of the wave's task that is the array's first.
    #[arg(long)]
    first: usize,
    #[command(flatten)]
    telling: ProgressArgs,
}

impl WorkCommand {
    pub(super) fn execute(self) -> CommandResult {
        let number = |name: &str| std::env::var(name).ok()?.parse::<usize>().ok();
        let Some(task) = number("SLURM_ARRAY_TASK_ID") else {
            let words = "SLURM_ARRAY_TASK_ID: found no number, expected a task of a job array of Slurm's";
            return Err(CommandError::BadInput(words.to_owned()));
        };
        let threads =
            if self.telling.jobs > 0 { self.telling.jobs } else { number("SLURM_CPUS_PER_TASK").unwrap_or(1) };
        let place = Place { attempt: self.attempt, wave: self.wave, task: self.first + task };
        let progress = self.telling.progress();
        match slurm::work(&Folder::at(&self.folder), place, threads, &progress).map_err(CommandError::Failed)? {
            Worked::Done => Ok(()),
            Worked::Requeued => Err(CommandError::Failed("told to end before everything was done".to_owned())),
        }
    }
}
