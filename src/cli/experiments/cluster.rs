//! Runs on a Slurm cluster: `run --executor slurm`, `status`, `cancel`, and `work`, which the
//! cluster starts.

use crate::cli::program::shared::{CacheArgs, ThreadArgs, print_all};
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::runner::slurm::{self, CampaignEnd, CampaignFolder, CampaignMonitor};
use spinebench::runner::{Campaign, Progress, Store};
use spinebench::specs::SlurmOptions;
use std::fmt::Write as _;
use std::path::PathBuf;

/// What is asked of the cluster; overrides `slurm:` of the specs.
#[derive(Args)]
#[command(next_help_heading = "Slurm")]
pub(crate) struct SlurmArgs {
    /// Partition.
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,
    /// Account to charge.
    #[arg(long, value_name = "NAME")]
    account: Option<String>,
    /// Time limit of a worker, minutes.
    #[arg(long, value_name = "MINUTES")]
    time_min: Option<u32>,
    /// Memory of a worker, megabytes.
    #[arg(long, value_name = "MEGABYTES")]
    memory_mb: Option<u32>,
    /// Processors of a worker.
    #[arg(long, value_name = "N")]
    pub(crate) cpus: Option<u32>,
    /// Submit and return; run the same command again to wait and publish.
    #[arg(long)]
    detach: bool,
}

impl SlurmArgs {
    /// Computes what is missing on the cluster; the campaign's folder, or nothing when the jobs
    /// continue unattended.
    pub(crate) fn fill(
        &self,
        campaign: &Campaign,
        store: &Store,
        workers: usize,
        progress: &Progress,
    ) -> Result<Option<CampaignFolder>, CommandError> {
        let options = self.options(campaign)?;
        if options.task_s.is_some() {
            progress.notice(
                "slurm.task_s has no effect: workers take single stages; remove it from the spec",
            );
        }
        let root = std::path::absolute(store.root()).map_err(CommandError::failed)?;
        let store = Store::at(root);
        let monitor = CampaignMonitor {
            campaign,
            store: &store,
            options: &options,
            workers,
            detach: self.detach,
            progress,
        };
        match monitor.run().map_err(CommandError::Failed)? {
            CampaignEnd::Complete(folder) => Ok(Some(folder)),
            CampaignEnd::Cancelled => {
                Err(CommandError::Failed(format!("campaign {} was cancelled", monitor.id())))
            }
            CampaignEnd::Detached => {
                let id = monitor.id();
                progress.say(&format!(
                    "the jobs continue; use `spinebench status` or `spinebench cancel {id}`, or \
                     run the same command again to wait and publish"
                ));
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
            refuse!("slurm: found other settings in `{other}` than in `{one}`, expected the same");
        }
        let spec_options = first.slurm.clone();
        let options = SlurmOptions {
            partition: self.partition.clone().or(spec_options.partition),
            account: self.account.clone().or(spec_options.account),
            time_min: self.time_min.or(spec_options.time_min),
            memory_mb: self.memory_mb.or(spec_options.memory_mb),
            cpus: self.cpus.unwrap_or(spec_options.cpus),
            ..spec_options
        };
        let refuse = |bad: spinebench::base::BadOption| {
            let option = bad.key.replace('_', "-");
            CommandError::BadInput(format!(
                "--{option}: found {}, expected {}",
                bad.found, bad.expected
            ))
        };
        options.check().map_err(refuse)?;
        Ok(options)
    }
}

/// Show the state of the campaigns that were submitted to a cluster.
#[derive(Args)]
pub(crate) struct StatusCommand {
    #[command(flatten)]
    cache: CacheArgs,
}

impl StatusCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let mut text = String::new();
        for one in slurm::campaigns(&self.cache.store()) {
            let (id, names, done, all) = (&one.id, one.experiments.join(" "), one.done, one.stages);
            let failed =
                if one.failed > 0 { format!(", {} failed", one.failed) } else { String::new() };
            let cancelled = if one.cancelled { ", cancelled" } else { "" };
            let _ = writeln!(
                text,
                "{id}  {names}: {done} of {all} stages{failed}{cancelled}; {}",
                one.queue
            );
        }
        if text.is_empty() {
            text = "no campaigns\n".to_owned();
        }
        print_all(text.as_bytes());
        Ok(())
    }
}

/// Cancel a campaign's jobs; cached results are kept.
#[derive(Args)]
pub(crate) struct CancelCommand {
    /// Name of the campaign, as `status` prints it.
    #[arg(value_name = "CAMPAIGN")]
    id: String,
    #[command(flatten)]
    cache: CacheArgs,
}

impl CancelCommand {
    pub(crate) fn execute(self) -> CommandResult {
        slurm::cancel(&self.cache.store(), &self.id).map_err(CommandError::BadInput)
    }
}

/// Run stages of a campaign; the cluster starts this command.
#[derive(Args)]
pub(crate) struct WorkCommand {
    /// Folder of the campaign.
    folder: PathBuf,
    /// Number of workers.
    #[arg(long)]
    workers: usize,
    #[command(flatten)]
    threads: ThreadArgs,
}

impl WorkCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let number = |name: &str| {
            let number = std::env::var(name).ok().and_then(|text| text.parse::<usize>().ok());
            let expected = "expected a task of a Slurm job array";
            number.ok_or_else(|| {
                CommandError::BadInput(format!("{name}: found no number, {expected}"))
            })
        };
        // The number of this process among all tasks of all jobs of the array.
        let worker =
            number("SLURM_ARRAY_TASK_ID")? * number("SLURM_NTASKS")? + number("SLURM_PROCID")?;
        let threads = match self.threads.jobs {
            0 => number("SLURM_CPUS_PER_TASK").unwrap_or(1),
            threads => threads,
        };
        let folder = CampaignFolder::at(&self.folder);
        let summary = slurm::work(&folder, worker, self.workers, threads, progress)
            .map_err(CommandError::Failed)?;
        if summary.stopped {
            std::process::exit(i32::from(slurm::STAGES_LEFT_STATUS));
        }
        Ok(())
    }
}
