//! Submits the workers of a campaign and waits until everything is stored or has failed, or until
//! somebody ends it.

use super::campaign_folder::{CANCELLED, CampaignContents, CampaignFolder, FINISHED, REFUSED};
use super::queue;
use crate::hardware::interrupt::Interrupt;
use crate::runner::campaign::{Campaign, CampaignEntry};
use crate::runner::execute::executor::RunRecord as _;
use crate::runner::execute::plan::{Need, plan};
use crate::runner::execute::progress::{Progress, StageEvent};
use crate::runner::graph::Failure;
use crate::runner::graph::key::Key;
use crate::runner::store::Store;
use crate::specs::SlurmOptions;
use std::collections::HashSet;
use std::time::{Duration, Instant};

/// How often the store is looked at.
const STORE_INTERVAL: Duration = Duration::from_millis(500);
/// How often the cluster is asked.
const QUEUE_INTERVAL: Duration = Duration::from_secs(3);
/// How long the queue may be empty before missing results count as lost: a shared folder may lag
/// behind.
const MAX_EMPTY_QUEUE: Duration = Duration::from_secs(6);
/// Without a number from the user: most workers, and estimated work for each, milliseconds.
const MAX_DEFAULT_WORKERS: u64 = 100;
const WORK_PER_DEFAULT_WORKER_MS: u64 = 10_000;

/// How waiting for a campaign ended.
#[derive(Debug)]
pub enum CampaignEnd {
    /// Every stage is stored or has failed; the folder has the failures.
    Complete(CampaignFolder),
    /// The jobs continue without anybody waiting.
    Detached,
    /// Somebody cancelled it.
    Cancelled,
}

/// A campaign on a cluster.
pub struct CampaignMonitor<'a> {
    /// Its stages.
    pub campaign: &'a Campaign,
    /// Where its results go, as an absolute path.
    pub store: &'a Store,
    /// What it asks of the cluster.
    pub options: &'a SlurmOptions,
    /// Workers; 0: one for each ten seconds of estimated work, at most a hundred.
    pub workers: usize,
    /// Return as soon as the workers are submitted.
    pub detach: bool,
    /// Where progress is reported.
    pub progress: &'a Progress,
}

impl CampaignMonitor<'_> {
    /// The name of the campaign.
    pub fn id(&self) -> String {
        CampaignFolder::id_of(self.campaign)
    }

    /// Submits workers unless the campaign's are in the queue, and waits for their results.
    ///
    /// # Errors
    /// What the file system or the cluster says.
    pub fn run(&self) -> Result<CampaignEnd, String> {
        let id = self.id();
        let folder = CampaignFolder::of(self.store, &id);
        let missing = self.missing();
        if missing.is_empty() {
            return Ok(CampaignEnd::Complete(folder));
        }
        let specs: Vec<_> = self.campaign.entries.iter().map(CampaignEntry::spec_yaml).collect();
        folder.create(&specs, &self.contents(&missing))?;
        let Some(_lock) = folder.lock() else {
            return Err(format!(
                "campaign {id} is watched by another process; `spinebench status` shows its state"
            ));
        };
        folder.forget(&[CANCELLED]);
        let jobs = queue::jobs(&folder.job_name())?;
        if jobs.is_empty() {
            folder.forget(&["failed", "workers"]);
            self.submit(&folder, &missing)?;
        } else {
            self.progress.say(&format!(
                "campaign {id} is under way ({}); watching it",
                queue::describe(&jobs)
            ));
        }
        if folder.marked(CANCELLED).is_some() {
            return Ok(CampaignEnd::Cancelled);
        }
        if self.detach { Ok(CampaignEnd::Detached) } else { self.wait(folder, missing) }
    }

    /// Stages that are needed and not stored.
    fn missing(&self) -> Vec<usize> {
        let needs = plan(&self.campaign.graph, self.store, &self.campaign.wanted());
        (0..needs.len()).filter(|&stage| needs[stage] == Need::Compute).collect()
    }

    fn contents(&self, missing: &[usize]) -> CampaignContents {
        let describe = |&stage: &usize| self.campaign.graph.describe(stage);
        CampaignContents {
            experiments: self
                .campaign
                .entries
                .iter()
                .map(|entry| entry.experiment.name.clone())
                .collect(),
            stages: missing
                .iter()
                .map(describe)
                .map(|(kind, _, key)| (kind.to_owned(), key))
                .collect(),
        }
    }

    fn submit(&self, folder: &CampaignFolder, missing: &[usize]) -> Result<(), String> {
        folder.forget(&[FINISHED, REFUSED, "shares"]);
        folder.put_missing(missing)?;
        let work_ms: u64 = missing.iter().map(|&stage| self.campaign.graph.cost_ms(stage)).sum();
        let workers = match self.workers {
            0 => (work_ms / WORK_PER_DEFAULT_WORKER_MS).clamp(1, MAX_DEFAULT_WORKERS) as usize,
            workers => workers,
        };
        let array = queue::WorkerArray::of(workers.min(missing.len()), self.options);
        queue::submit(folder, array, self.options)?;
        // Who cancels marks the campaign first and then cancels the jobs that are there.
        if folder.marked(CANCELLED).is_some() {
            return queue::cancel(&folder.job_name(), false);
        }
        let (id, stages) = (self.id(), missing.len());
        self.progress
            .say(&format!("campaign {id}: submitted {} for {stages} stages", array.describe()));
        Ok(())
    }

    fn wait(&self, folder: CampaignFolder, missing: Vec<usize>) -> Result<CampaignEnd, String> {
        let graph = &self.campaign.graph;
        let stages = missing.iter().map(|&stage| (graph.describe(stage).0, graph.cost_ms(stage)));
        let usual = |kind: &str| self.store.seconds_per_cost(kind);
        self.progress.planned(stages, 0, self.workers.max(1), &usual);
        let interrupt = Interrupt::of_process().map_err(|error| error.to_string())?;
        let (mut unfinished, mut queue) = (missing, QueueWatch::new(folder.job_name()));
        // Unfinished stages when workers were last submitted, and how often that came to nothing.
        let (mut submitted, mut vain_attempts) = (unfinished.len(), 0);
        loop {
            let look_began = Instant::now();
            let failed = folder.failed();
            unfinished.retain(|&stage| !self.has_ended(stage, &folder, &failed));
            if unfinished.is_empty() {
                self.progress.done();
                // Workers that wait for a free node have nothing to do any more; the others end by
                // themselves.
                let _ = queue::cancel(&folder.job_name(), true);
                return Ok(CampaignEnd::Complete(folder));
            }
            if let Some(reason) = folder.marked(REFUSED) {
                return Err(reason);
            }
            if folder.marked(CANCELLED).is_some() {
                self.progress.done();
                return Ok(CampaignEnd::Cancelled);
            }
            if interrupt.raised() {
                self.progress.done();
                return Ok(CampaignEnd::Detached);
            }
            if !queue.has_ended(self.progress) {
                // A large campaign on a slow folder is not looked at all the time.
                std::thread::sleep(STORE_INTERVAL.max(10 * look_began.elapsed()));
                continue;
            }
            vain_attempts = if unfinished.len() < submitted { 0 } else { vain_attempts + 1 };
            submitted = unfinished.len();
            if vain_attempts >= self.options.attempts {
                unfinished.iter().for_each(|&stage| self.give_up(stage, &folder));
                continue;
            }
            self.progress.notice(&format!(
                "the workers ended with {submitted} stages missing; submitting these stages again"
            ));
            // A cluster that refuses now may not a while later: it counts as an attempt in vain.
            if let Err(error) = self.submit(&folder, &self.missing()) {
                self.progress.notice(&error);
            }
        }
    }

    /// Whether a stage is stored or has failed; reports it.
    fn has_ended(&self, stage: usize, folder: &CampaignFolder, failed: &HashSet<Key>) -> bool {
        let graph = &self.campaign.graph;
        let (kind, label, key) = graph.describe(stage);
        let has_failed = failed.contains(&key);
        if !has_failed && !self.store.contains(kind, &key) {
            return false;
        }
        let short = key.short();
        let event = StageEvent {
            number: stage,
            stage: kind,
            label,
            key: &short,
            cost_ms: graph.cost_ms(stage),
        };
        let timing = self.store.noted(kind, &key).map(|note| note.timing).unwrap_or_default();
        // A failure that it inherits from an input is reported once, for the input.
        let failure =
            folder.find_failure(&key).filter(|failure| has_failed && failure.stage == kind);
        self.progress.finished(
            event,
            timing,
            failure.as_ref().map(|failure| failure.status.as_str()),
        );
        true
    }

    /// Records as failed what came to nothing however often workers were submitted.
    fn give_up(&self, stage: usize, folder: &CampaignFolder) {
        let (kind, _, key) = self.campaign.graph.describe(stage);
        let (times, logs) = (self.options.attempts, folder.logs());
        let status =
            format!("lost on the cluster {times} times; its output is in {}", logs.display());
        folder.record_failure(&key, &Failure { stage: kind.to_owned(), status });
    }
}

/// Watches for the time when no job of a campaign is in the queue.
struct QueueWatch {
    name: String,
    last_query: Option<Instant>,
    empty_since: Option<Instant>,
    reported: String,
}

impl QueueWatch {
    fn new(name: String) -> QueueWatch {
        QueueWatch { name, last_query: None, empty_since: None, reported: String::new() }
    }

    /// Whether the queue has been empty for a while; reports why jobs do not start.
    fn has_ended(&mut self, progress: &Progress) -> bool {
        if self.last_query.is_some_and(|last_query| last_query.elapsed() < QUEUE_INTERVAL) {
            return false;
        }
        self.last_query = Some(Instant::now());
        let trouble = match queue::jobs(&self.name) {
            Ok(states) if states.is_empty() => {
                let ended =
                    self.empty_since.get_or_insert_with(Instant::now).elapsed() >= MAX_EMPTY_QUEUE;
                self.empty_since.take_if(|_| ended);
                return ended;
            }
            // Some reasons to wait need a person: a hold, a limit, a resource that no node has.
            Ok(states) => states.into_keys().find(|state| state.contains('(')),
            // A controller that does not answer is waited for: results come without it.
            Err(error) => Some(error),
        };
        self.empty_since = None;
        if let Some(trouble) = trouble.filter(|trouble| *trouble != self.reported) {
            progress.notice(&format!("the cluster: {trouble}"));
            self.reported = trouble;
        }
        false
    }
}
