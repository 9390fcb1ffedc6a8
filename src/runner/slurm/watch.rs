//! Submits a campaign and watches it until everything is in the store, has failed, or somebody ends it.

use super::folder::{About, Folder};
use super::queue::{self, Array};
use super::{job_name, plan};
use crate::hardware::interrupt::Interrupt;
use crate::runner::campaign::Campaign;
use crate::runner::graph::Failure;
use crate::runner::key::Key;
use crate::runner::plan::{Need, plan};
use crate::runner::progress::{Progress, StageEvent};
use crate::runner::store::Store;
use crate::specs::SlurmOptions;
use std::collections::{BTreeMap, HashMap};
use std::time::{Duration, Instant};

/// How often the store is looked at.
const LOOK: Duration = Duration::from_millis(500);
/// How often the cluster is asked.
const ASK: Duration = Duration::from_secs(3);
/// How long the queue may be empty with results missing before they are taken for lost: a shared folder may lag behind.
const GRACE: Duration = Duration::from_secs(6);

/// How watching ended.
#[derive(Debug)]
pub enum Ended {
    /// Everything is in the store, or has failed in the way that is told.
    Done(HashMap<Key, Failure>),
    /// The jobs go on without anybody watching.
    Detached,
    /// Somebody has called the campaign off.
    Cancelled,
}

/// A campaign on a cluster.
pub struct Watch<'a> {
    /// Its stages.
    pub campaign: &'a Campaign,
    /// Where its results go, as an absolute path.
    pub store: &'a Store,
    /// What it asks of the cluster.
    pub options: &'a SlurmOptions,
    /// Tasks that may run at a time; 0: any number.
    pub at_a_time: usize,
    /// Leave as soon as everything is submitted.
    pub detach: bool,
    /// Whom it is told to.
    pub progress: &'a Progress,
}

impl Watch<'_> {
    /// The name of the campaign: what asks for the same results by the same code has the same.
    pub fn id(&self) -> String {
        Folder::id(self.campaign.wanted().into_iter().map(|stage| self.campaign.graph.describe(stage).2))
    }

    /// Submits what is neither stored nor under way, and watches it.
    ///
    /// # Errors
    /// What the file system or the cluster says, in words.
    pub fn run(&self) -> Result<Ended, String> {
        let id = self.id();
        let folder = Folder::of(self.store, &id);
        let needs = plan(&self.campaign.graph, self.store, &self.campaign.wanted());
        let missing: Vec<usize> = (0..needs.len()).filter(|&stage| needs[stage] == Need::Compute).collect();
        if missing.is_empty() {
            return Ok(Ended::Done(HashMap::new()));
        }
        let specs = self.campaign.entries.iter().map(|entry| entry.spec_yaml().map_err(|error| error.to_string()));
        folder.begin(&specs.collect::<Result<Vec<_>, _>>()?, &self.about(&missing))?;
        let Some(_right) = folder.watch() else {
            return Err(format!(
                "campaign {id} is watched by another process; `spinebench status` tells how it stands"
            ));
        };
        folder.call_off(false)?;
        let alive = queue::queued(&job_name(&folder))?;
        if alive.is_empty() {
            folder.forget_failures();
            self.submit(&folder, &needs)?;
        } else {
            self.progress.say(&format!("campaign {id} is under way already ({}); watching it", queue::words(&alive)));
        }
        if folder.called_off() {
            return Ok(Ended::Cancelled);
        }
        if self.detach {
            return Ok(Ended::Detached);
        }
        self.watch(&folder, &needs, missing)
    }

    fn about(&self, missing: &[usize]) -> About {
        let describe = |&stage: &usize| self.campaign.graph.describe(stage);
        About {
            experiments: self.campaign.entries.iter().map(|entry| entry.experiment.name.clone()).collect(),
            waited_for: missing.iter().map(describe).map(|(_, _, key)| key).collect(),
            kinds: missing.iter().map(describe).map(|(kind, _, _)| kind.to_owned()).collect(),
        }
    }

    /// Submits what is needed as the next attempt: a wave after the other, each as arrays of the size that is allowed.
    fn submit(&self, folder: &Folder, needs: &[Need]) -> Result<(), String> {
        let waves = plan::waves(&self.campaign.graph, needs, (self.options.task_s * 1e3) as u64);
        let attempt = folder.last_attempt() + 1;
        folder.put_attempt(attempt, &self.campaign.graph, &waves)?;
        let (name, largest) = (job_name(folder), queue::largest_array());
        let mut after: Vec<String> = Vec::new();
        let mut tasks = 0;
        for (wave, list) in waves.iter().enumerate() {
            let mut jobs: Vec<String> = Vec::new();
            for first in (0..list.len()).step_by(largest) {
                let at_a_time = self.at_a_time;
                // The limit is of one array: where a wave has several, one follows the other.
                let before = if at_a_time > 0 { jobs.last().map(std::slice::from_ref) } else { None };
                let (first, tasks) = (first, largest.min(list.len() - first));
                let array =
                    Array { name: &name, attempt, wave, first, tasks, at_a_time, after: before.unwrap_or(&after) };
                match queue::submit(folder, &array, self.options) {
                    Ok(job) => jobs.push(job),
                    Err(words) if jobs.is_empty() && after.is_empty() => return Err(words),
                    // What is submitted goes on; what is not counts as lost when that is done, and is submitted then.
                    Err(words) => {
                        self.progress.notice(&format!("{words}; the rest follows when what is submitted is done"));
                        return Ok(());
                    }
                }
                // Who cancels marks the campaign first and then cancels the jobs that are there.
                if folder.called_off() {
                    return queue::cancel(&name);
                }
            }
            tasks += list.len();
            after = jobs;
        }
        let (id, waves) = (self.id(), waves.len());
        self.progress.say(&format!("campaign {id}: submitted {tasks} tasks in {waves} waves"));
        Ok(())
    }

    fn watch(&self, folder: &Folder, needs: &[Need], missing: Vec<usize>) -> Result<Ended, String> {
        let graph = &self.campaign.graph;
        let cached = needs.iter().filter(|&&need| need == Need::Cached).count();
        let kinds = missing.iter().map(|&stage| (graph.describe(stage).0, graph.cost_ms(stage)));
        self.progress.planned(kinds, cached);
        let interrupt = Interrupt::of_process().map_err(|error| error.to_string())?;
        let mut left = missing;
        let mut silence = Silence::new(left.len());
        let ended = loop {
            let looked = Instant::now();
            let failures = folder.failures();
            left.retain(|&stage| !self.is_over(stage, &failures));
            if left.is_empty() {
                break Ended::Done(failures);
            }
            if folder.called_off() {
                break Ended::Cancelled;
            }
            if interrupt.raised() {
                break Ended::Detached;
            }
            match silence.look(left.len(), || queue::queued(&job_name(folder)), self.progress) {
                // A large campaign on a slow folder is not looked at all the time.
                Silent::No => std::thread::sleep(LOOK.max(10 * looked.elapsed())),
                Silent::Lost if silence.in_vain >= self.options.attempts => {
                    break Ended::Done(self.lost(folder, &left, failures));
                }
                Silent::Lost => {
                    self.progress
                        .notice(&format!("{} stages got lost on the cluster; submitting them again", left.len()));
                    // A cluster that refuses now may not a while later: it counts as an attempt in vain.
                    if let Err(words) = self.submit(folder, &plan(graph, self.store, &self.campaign.wanted())) {
                        self.progress.notice(&words);
                    }
                }
            }
        };
        self.progress.done();
        Ok(ended)
    }

    /// Whether a stage is in the store, has failed or cannot be computed any more; tells of it.
    fn is_over(&self, stage: usize, failures: &HashMap<Key, Failure>) -> bool {
        let graph = &self.campaign.graph;
        let (kind, label, key) = graph.describe(stage);
        let failure = failures.get(&key);
        let over = failure.is_some() || self.store.contains(kind, &key);
        if over {
            let short = key.short();
            let told = StageEvent { stage: kind, label, key: &short, cost_ms: graph.cost_ms(stage) };
            let timing = self.store.noted(kind, &key).map(|note| note.timing).unwrap_or_default();
            let own = failure.filter(|failure| failure.stage == kind).map(|failure| failure.status.as_str());
            self.progress.finished(told, timing, own);
        }
        over
    }

    /// Stages that came to nothing however often they were submitted, as failures.
    fn lost(&self, folder: &Folder, left: &[usize], mut failures: HashMap<Key, Failure>) -> HashMap<Key, Failure> {
        let (times, logs) = (self.options.attempts, folder.logs());
        for &stage in left {
            let (kind, _, key) = self.campaign.graph.describe(stage);
            let status = format!("lost on the cluster {times} times; its output is in {}", logs.display());
            failures.insert(key, Failure { stage: kind.to_owned(), status });
        }
        failures
    }
}

/// Whether anybody is still at work.
enum Silent {
    /// Somebody is, or it is too early to tell.
    No,
    /// Nobody is, and results are missing.
    Lost,
}

/// Watches the queue for the time when nobody is at work any more.
struct Silence {
    asked: Option<Instant>,
    since: Option<Instant>,
    /// What was missing when the last attempt was submitted.
    missing: usize,
    /// Attempts since anything new has come.
    in_vain: u32,
    told: String,
}

impl Silence {
    fn new(missing: usize) -> Silence {
        Silence { asked: None, since: None, missing, in_vain: 0, told: String::new() }
    }

    fn look(
        &mut self,
        missing: usize,
        queued: impl FnOnce() -> Result<BTreeMap<String, usize>, String>,
        progress: &Progress,
    ) -> Silent {
        if self.asked.is_some_and(|asked| asked.elapsed() < ASK) {
            return Silent::No;
        }
        self.asked = Some(Instant::now());
        let told = match queued() {
            Ok(states) if states.is_empty() => {
                let since = *self.since.get_or_insert_with(Instant::now);
                if since.elapsed() < GRACE {
                    return Silent::No;
                }
                self.in_vain = if missing < self.missing { 0 } else { self.in_vain + 1 };
                (self.missing, self.since) = (missing, None);
                return Silent::Lost;
            }
            // Some reasons to wait need a person: a hold, a limit, a resource that no node has.
            Ok(states) => states.keys().find(|state| state.contains('(')).cloned(),
            // A controller that does not answer is waited for: results come without it.
            Err(words) => Some(words),
        };
        self.since = None;
        if let Some(words) = told.filter(|words| *words != self.told) {
            progress.notice(&format!("the cluster: {words}"));
            self.told = words;
        }
        Silent::No
    }
}
