//! `spinebench run`.

use super::cluster::SlurmArgs;
use crate::cli::program::interrupted::exit_on_interrupt;
use crate::cli::program::outputs::check_folder;
use crate::cli::program::shared::{CacheArgs, ResultsArg, SpecArgs, ThreadArgs};
use crate::cli::{CommandError, CommandResult};
use clap::{Args, ValueEnum};
use spinebench::runner::{
    self, Campaign, CampaignEntry, FailedCell, Outcomes, Progress, Publication, RunFacts,
    RunOptions, StageTimes,
};
use spinebench::specs::differing_keys;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::thread::available_parallelism;
use std::time::Instant;

/// Expand specs to stages, run the stages that are not stored, write tables and figures.
#[derive(Args)]
pub(crate) struct RunCommand {
    #[command(flatten)]
    specs: SpecArgs,
    #[command(flatten)]
    results: ResultsArg,
    #[command(flatten)]
    cache: CacheArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Exit with status 1 when a claim is not reproduced or a trial failed (always for a failed
    /// stage and for a cell in which every trial failed).
    #[arg(long)]
    strict: bool,
    /// Where to run stages.
    #[arg(long, value_enum, default_value_t = Executor::Local)]
    executor: Executor,
    #[command(flatten)]
    cluster: SlurmArgs,
}

/// Bytes of the tables and figures of an experiment, about.
const EXPERIMENT_BYTES: usize = 1 << 20;

/// Where stages run.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Executor {
    /// On this machine's threads.
    Local,
    /// On a Slurm cluster that shares this folder, with `--jobs` workers.
    Slurm,
}

impl RunCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let campaign = self.specs.campaign(|note| progress.notice(note))?;
        let out = self.results.folder(progress);
        check_folder(&out, campaign.entries.len() * EXPERIMENT_BYTES)?;
        for entry in &campaign.entries {
            tell_replaced(progress, entry, &out);
        }
        // The repository may change during the run.
        let revision = runner::git_revision();
        let began = Instant::now();
        let wanted = campaign.wanted();
        let store = self.cache.store();
        let jobs = self.threads.jobs;
        let mut folder = None;
        if self.executor == Executor::Slurm {
            folder = self.cluster.fill(&campaign, &store, jobs, progress)?;
            if folder.is_none() {
                return Ok(());
            }
        }
        // The monitor of a cluster tells itself what Ctrl-C means.
        if folder.is_none() {
            exit_on_interrupt(
                "interrupted; the computed stages are stored, and the same command resumes",
            );
        }
        let options = match &folder {
            Some(folder) => RunOptions { record: folder, ..RunOptions::new(1, progress) },
            None => RunOptions::new(jobs, progress),
        };
        let outcomes = runner::execute(&campaign.graph, &store, &wanted, &options)
            .map_err(|failure| CommandError::Failed(failure.to_string()))?;
        let wall_s = began.elapsed().as_secs_f64();
        let about = RunFacts { revision: &revision, threads: &|entry| self.threads(entry), wall_s };
        let published = runner::publish_all(&campaign, &outcomes, &store, &out, &about)
            .map_err(CommandError::Failed)?;
        summarise(progress, &campaign, &outcomes, &published, wall_s);
        tell_files(progress, &campaign, &published, &out);
        folder.iter().for_each(|folder| progress.say(&folder.describe_workers()));
        if let [first, ..] = outcomes.failures.as_slice() {
            let count = outcomes.failures.len();
            let words = format!(
                "{count} stages failed, the first is {first}; rows of dependent trials contain the \
                 failure"
            );
            return Err(CommandError::Failed(words));
        }
        self.verdict(&published)
    }

    /// Number of threads of a stage, on this machine or in a task on the cluster.
    fn threads(&self, entry: &CampaignEntry) -> usize {
        match self.executor {
            Executor::Slurm => self.cluster.cpus.unwrap_or(entry.experiment.slurm.cpus) as usize,
            Executor::Local if self.threads.jobs > 0 => self.threads.jobs,
            Executor::Local => available_parallelism().map_or(1, usize::from),
        }
    }

    fn verdict(&self, published: &[Publication]) -> CommandResult {
        let failed: usize = published.iter().map(|publication| publication.failed).sum();
        let claims = published.iter().flat_map(|publication| &publication.claims);
        let denied: Vec<&str> = claims
            .filter(|row| row.verdict == "not reproduced")
            .map(|row| row.claim.as_str())
            .collect();
        if self.strict && failed > 0 {
            return Err(CommandError::Failed(format!("{failed} trials failed")));
        }
        let failed_cells: Vec<&FailedCell> =
            published.iter().flat_map(|publication| &publication.failed_cells).collect();
        if let [FailedCell { cell, trials, why }, further @ ..] = failed_cells.as_slice() {
            let others = match further.len() {
                0 => String::new(),
                1 => ", and every trial of 1 other cell".to_owned(),
                count => format!(", and every trial of {count} other cells"),
            };
            let words = format!(
                "every trial of {cell} failed ({trials} trials, first failure: {why}){others}"
            );
            return Err(CommandError::Failed(words));
        }
        if self.strict && !denied.is_empty() {
            return Err(CommandError::Failed(format!("not reproduced: {}", denied.join(", "))));
        }
        Ok(())
    }
}

/// A note where the results that an experiment replaces are those of other settings.
fn tell_replaced(progress: &Progress, entry: &CampaignEntry, out: &Path) {
    let folder = out.join("results").join(&entry.experiment.name);
    let Ok(there) = std::fs::read_to_string(folder.join("spec.yaml")) else { return };
    let keys = differing_keys(&there, &String::from_utf8_lossy(&entry.spec_yaml()));
    if !keys.is_empty() {
        let (folder, keys) = (folder.display(), keys.join("`, `"));
        progress.notice(&format!(
            "{folder}/ contains results of other settings (`{keys}`); they are replaced"
        ));
    }
}

fn summarise(
    progress: &Progress,
    campaign: &Campaign,
    outcomes: &Outcomes,
    published: &[Publication],
    wall_s: f64,
) {
    let failed: usize = published.iter().map(|publication| publication.failed).sum();
    published
        .iter()
        .flat_map(|publication| &publication.notices)
        .for_each(|notice| progress.notice(notice));
    let remarks = published.iter().flat_map(|publication| &publication.remarks);
    remarks.for_each(|remark| progress.say(remark));
    let (computed, cached) = (outcomes.computed, outcomes.cached);
    progress.say(&format!(
        "{computed} stages computed, {cached} read, {failed} trials failed, {wall_s:.1} s"
    ));
    for (kind, times) in times_by_kind(campaign, outcomes) {
        let StageTimes { count, computed, wall_s, cpu_s } = times;
        progress.say(&format!(
            "  {kind:16} {count:5} stages {computed:5} computed {wall_s:9.2} s \
                           {cpu_s:9.2} s processor"
        ));
    }
    let mut verdicts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in published.iter().flat_map(|publication| &publication.claims) {
        *verdicts.entry(&row.verdict).or_default() += 1;
    }
    if !verdicts.is_empty() {
        let counts: Vec<String> =
            verdicts.iter().map(|(verdict, count)| format!("{count} {verdict}")).collect();
        progress.say(&format!("claims: {}", counts.join(", ")));
    }
}

/// Where the tables and figures of each experiment are.
fn tell_files(progress: &Progress, campaign: &Campaign, published: &[Publication], out: &Path) {
    for (entry, publication) in campaign.entries.iter().zip(published) {
        let name = &entry.experiment.name;
        // Of a picture the PNG: beside it lie its other sizes and its caption.
        let is_shown = |path: &&PathBuf| {
            let end = if path.starts_with("plots") { "png" } else { "md" };
            path.extension().is_some_and(|found| found == end)
        };
        let shown = publication
            .files
            .keys()
            .filter(is_shown)
            .map(|path| out.join(path).display().to_string());
        let mut places = vec![format!("{}/", out.join("results").join(name).display())];
        places.extend(shown);
        progress.say(&format!("{name}: {}", places.join(", ").replace("./", "")));
    }
}

/// Run time by kind of stage, longest first, without kinds of which nothing was computed.
fn times_by_kind<'a>(campaign: &'a Campaign, outcomes: &Outcomes) -> Vec<(&'a str, StageTimes)> {
    let times = runner::stage_times(campaign, 0..campaign.graph.len(), outcomes);
    let mut times: Vec<(&str, StageTimes)> =
        times.into_iter().filter(|(_, times)| times.computed > 0).collect();
    times.sort_by(|(_, left), (_, right)| right.wall_s.total_cmp(&left.wall_s));
    times
}
