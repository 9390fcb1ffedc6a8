//! Executes a graph: computes what is wanted and not stored, each stage as soon as its inputs are
//! there. Processes that share a store share the work: whoever computes a stage holds the lock of
//! its entry, and the others take other stages meanwhile.

use super::outcomes::{Outcomes, SharingCost, StageOutcome};
use super::plan::{Need, plan_with};
use super::progress::{Progress, StageEvent};
use super::stage_queue::{StageQueue, WorkPlan};
use crate::base::with_share_listener;
use crate::runner::graph::key::Key;
use crate::runner::graph::stage::{AnyResult, InputResults};
use crate::runner::graph::timing::{Timing, timed};
use crate::runner::graph::{Failure, Graph, StageNode};
use crate::runner::store::{EntryLock, Lookup, Note, Store};
use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{SendError, SyncSender, sync_channel};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, available_parallelism};
use std::time::{Duration, Instant};

/// How long a thread without work waits before it asks again for stages that other processes
/// compute; twice as long each time, up to [`MAX_PAUSE`].
pub const MIN_PAUSE: Duration = Duration::from_millis(50);
/// Longest such wait, and so the longest until a thread without work sees that it shall stop.
pub const MAX_PAUSE: Duration = Duration::from_secs(2);
/// Postponed stages that it tries again after a pause.
pub const MAX_RESUMED_STAGES: usize = 16;
/// How often a thread without work of its own asks which shares are finished.
pub const EXCHANGE_INTERVAL: Duration = Duration::from_secs(1);
/// Results that one of several workers keeps in memory; it reads older ones again.
pub const MAX_RESULTS_IN_MEMORY: usize = 200;
/// Results that it may have computed and not stored yet.
pub const MAX_UNWRITTEN_RESULTS: usize = 8;

/// How a graph is executed.
pub struct RunOptions<'a> {
    /// Threads; 0: one per processor.
    pub threads: usize,
    /// Where progress is reported.
    pub progress: &'a Progress,
    /// Once true, no stage is started; those under way are completed.
    pub stop: &'a AtomicBool,
    /// What processes that share the run tell each other.
    pub record: &'a dyn RunRecord,
}

impl<'a> RunOptions<'a> {
    /// A run on `threads` threads (0: one per processor) to its end.
    pub fn new(threads: usize, progress: &'a Progress) -> RunOptions<'a> {
        static NEVER: AtomicBool = AtomicBool::new(false);
        RunOptions { threads, progress, stop: &NEVER, record: &() }
    }
}

/// What processes that share a run tell each other beside the store.
pub trait RunRecord: Sync {
    /// The failure of a stage that is known to fail; it is not tried again.
    fn find_failure(&self, key: &Key) -> Option<Failure>;
    /// Records the failure of a stage.
    fn record_failure(&self, key: &Key, failure: &Failure);
    /// Shares of which all stages are finished.
    fn finished_shares(&self) -> Vec<usize>;
    /// Records that all stages of a share are finished.
    fn record_share(&self, share: usize);
}

/// The record of a run that is not shared.
impl RunRecord for () {
    fn find_failure(&self, _: &Key) -> Option<Failure> {
        None
    }
    fn record_failure(&self, _: &Key, _: &Failure) {}
    fn finished_shares(&self) -> Vec<usize> {
        Vec::new()
    }
    fn record_share(&self, _: usize) {}
}

/// One of several workers that share a run.
#[derive(Clone, Copy, Debug)]
pub struct WorkerShare<'a> {
    /// Its number, from 0.
    pub worker: usize,
    /// Number of workers.
    pub workers: usize,
    /// The stages that were missing when the workers were started.
    pub missing: &'a [usize],
}

/// Computes or reads the `wanted` stages.
///
/// # Errors
/// When no thread can be started.
pub fn execute(
    graph: &Graph,
    store: &Store,
    wanted: &[usize],
    options: &RunOptions,
) -> Result<Outcomes, Failure> {
    let mut values: Vec<Option<StageOutcome>> = graph.nodes.iter().map(|_| None).collect();
    let needs = plan_with(graph, wanted, |number, node| {
        values[number] = load(node, store, options.progress).map(Ok);
        values[number].is_some()
    });
    let plan = WorkPlan::new(graph, &needs, 1);
    Execution::new(graph, store, options, &plan, 0).run(&needs, values, wanted)
}

/// Computes missing stages as one of several workers, until none is left that this worker could
/// take.
///
/// # Errors
/// When no thread can be started.
pub fn execute_share(
    graph: &Graph,
    store: &Store,
    share: WorkerShare,
    options: &RunOptions,
) -> Result<Outcomes, Failure> {
    let mut needs = vec![Need::Cached; graph.len()];
    share.missing.iter().for_each(|&stage| needs[stage] = Need::Compute);
    let plan = WorkPlan::new(graph, &needs, share.workers);
    let mut execution = Execution::new(graph, store, options, &plan, share.worker);
    execution.sharing = Some(Sharing::default());
    execution.run(&needs, graph.nodes.iter().map(|_| None).collect(), &[])
}

/// Reads a stored result; `None` when there is none. One that fails its checks is reported and
/// removed.
fn load(node: &StageNode, store: &Store, progress: &Progress) -> Option<AnyResult> {
    let reason = match store.read(node.kind.name, &node.key) {
        Lookup::Absent => return None,
        Lookup::Found(bytes) => match (node.decode)(&bytes) {
            Ok(value) => return Some(value),
            Err(error) => error.to_string(),
        },
        Lookup::Damaged(reason) => reason,
    };
    let (kind, key) = (node.kind.name, node.key.short());
    progress
        .notice(&format!("stored result {kind} {key} is damaged ({reason}); computing it again"));
    store.discard(kind, &node.key);
    None
}

/// What the threads of one execution share. They are no pool of rayon's: a thread that waits there
/// for a part of its stage may begin another stage meanwhile, within the first, and another within
/// that.
struct Execution<'a> {
    graph: &'a Graph,
    store: &'a Store,
    options: &'a RunOptions<'a>,
    worker: usize,
    queue: Mutex<StageQueue<'a>>,
    /// Notified when stages have ended.
    stages_ended: Condvar,
    values: Vec<Mutex<Option<StageOutcome>>>,
    timings: Vec<Mutex<Option<Timing>>>,
    /// Uses of each result that are still to come; a wanted one counts one more, so that it stays.
    remaining_uses: Vec<AtomicUsize>,
    /// Of one of several workers.
    sharing: Option<Sharing>,
    cost: Mutex<SharingCost>,
    write_failed: AtomicBool,
}

/// What one of several workers has beside.
#[derive(Default)]
struct Sharing {
    /// The results in memory, the oldest first.
    in_memory: Mutex<VecDeque<usize>>,
    /// Takes results to the thread that stores them: a shared folder may be slow.
    writer: Mutex<Option<SyncSender<Unwritten>>>,
    /// When it last asked which shares are finished.
    last_exchange: Mutex<Option<Instant>>,
    /// Whether it has recorded its own share as finished.
    share_recorded: AtomicBool,
}

/// A computed result on its way to the store, with the lock of its entry.
struct Unwritten {
    number: usize,
    bytes: Vec<u8>,
    timing: Timing,
    _entry: EntryLock,
}

/// What came of a stage that was tried.
enum Attempt {
    /// It was computed, or has failed.
    Computed,
    /// It is stored.
    Stored,
    /// Another process computes it.
    Elsewhere,
    /// An input is not stored.
    MissingInput,
}

/// Locks a mutex, poisoned or not: a stage that panics is caught in [`compute`], where nothing is
/// locked.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn inner<T>(mutex: Mutex<T>) -> T {
    mutex.into_inner().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Execution<'a> {
    fn new(
        graph: &'a Graph,
        store: &'a Store,
        options: &'a RunOptions,
        plan: &'a WorkPlan,
        worker: usize,
    ) -> Execution<'a> {
        let mut remaining_uses = vec![0; graph.len()];
        for stage in plan.missing() {
            graph.inputs(stage).iter().for_each(|&input| remaining_uses[input] += 1);
        }
        Execution {
            graph,
            store,
            options,
            worker,
            queue: Mutex::new(StageQueue::new(plan, worker)),
            stages_ended: Condvar::new(),
            values: graph.nodes.iter().map(|_| Mutex::default()).collect(),
            timings: graph.nodes.iter().map(|_| Mutex::default()).collect(),
            remaining_uses: remaining_uses.into_iter().map(AtomicUsize::new).collect(),
            sharing: None,
            cost: Mutex::default(),
            write_failed: AtomicBool::new(false),
        }
    }

    fn run(
        mut self,
        needs: &[Need],
        values: Vec<Option<StageOutcome>>,
        wanted: &[usize],
    ) -> Result<Outcomes, Failure> {
        let cached = values.iter().flatten().count();
        self.values = values.into_iter().map(Mutex::new).collect();
        wanted.iter().for_each(|&stage| *self.remaining_uses[stage].get_mut() += 1);
        let missing = (0..needs.len()).filter(|&stage| needs[stage] == Need::Compute);
        let threads = match self.options.threads {
            0 => available_parallelism().map_or(1, usize::from),
            threads => threads,
        };
        let stages = missing.map(|stage| {
            let node = &self.graph.nodes[stage];
            (node.kind.name, node.cost_ms)
        });
        let usual = |kind: &str| self.store.seconds_per_cost(kind);
        self.options.progress.planned(stages, cached, threads, &usual);
        // Parts of stages share as many more; the first run of a process decides.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        let started_threads = std::thread::scope(|scope| {
            if let Some(sharing) = &self.sharing {
                let (sender, results) = sync_channel(MAX_UNWRITTEN_RESULTS);
                *lock(&sharing.writer) = Some(sender);
                scope.spawn(|| results.into_iter().for_each(|result| self.store_result(result)));
            }
            let spawn = |number: usize| {
                Builder::new().name(format!("stage {number}")).spawn_scoped(scope, || self.work())
            };
            let threads: Vec<_> = (0..threads).map(spawn).filter_map(Result::ok).collect();
            let started = threads.len();
            threads.into_iter().for_each(|thread| drop(thread.join()));
            // The writer ends when nothing can be sent any more.
            self.sharing.iter().for_each(|sharing| *lock(&sharing.writer) = None);
            started
        });
        if started_threads == 0 {
            return Err(Failure {
                stage: "threads".into(),
                status: "none could be started".into(),
            });
        }
        self.options.progress.done();
        Ok(self.outcomes(cached, wanted))
    }

    /// Computes stages until none is left for this thread or it shall stop.
    fn work(&self) {
        let mut pause = MIN_PAUSE;
        let mut queue = lock(&self.queue);
        while queue.unfinished() > 0 && !self.options.stop.load(Ordering::Relaxed) {
            self.exchange(&mut queue);
            let Some(stage) = queue.take() else {
                // So many stages keep at most so many workers busy: the others end.
                if queue.unfinished() <= self.worker {
                    break;
                }
                let paused = Instant::now();
                queue = self
                    .stages_ended
                    .wait_timeout(queue, pause)
                    .unwrap_or_else(PoisonError::into_inner)
                    .0;
                let mut cost = lock(&self.cost);
                cost.idle_s += paused.elapsed().as_secs_f64();
                cost.polls += usize::from(queue.resume(MAX_RESUMED_STAGES) > 0);
                pause = (2 * pause).min(MAX_PAUSE);
                continue;
            };
            let (owned, unknown) = (queue.owns(stage), queue.unknown_inputs(stage));
            drop(queue);
            let (stored, attempt) = self.attempt(stage, owned, &unknown);
            queue = lock(&self.queue);
            stored.iter().for_each(|&input| queue.mark_stored(input));
            match attempt {
                Attempt::Computed => queue.mark_computed(stage),
                Attempt::Stored => queue.mark_stored(stage),
                Attempt::Elsewhere => queue.postpone(stage),
                Attempt::MissingInput => queue.wait_for_inputs(stage),
            }
            if matches!(attempt, Attempt::Computed | Attempt::Stored) {
                pause = MIN_PAUSE;
                self.stages_ended.notify_all();
            }
        }
    }

    /// Before it steals, a worker tells that its own share is finished and asks which others are.
    fn exchange(&self, queue: &mut StageQueue) {
        let Some(sharing) = self.sharing.as_ref().filter(|_| queue.is_idle()) else { return };
        if queue.own_share_finished() && !sharing.share_recorded.swap(true, Ordering::Relaxed) {
            self.options.record.record_share(self.worker);
        }
        let mut last_exchange = lock(&sharing.last_exchange);
        if last_exchange.is_none_or(|last| last.elapsed() >= EXCHANGE_INTERVAL) {
            *last_exchange = Some(Instant::now());
            self.options
                .record
                .finished_shares()
                .into_iter()
                .for_each(|share| queue.mark_share_stored(share));
        }
    }

    /// Computes a stage unless it is stored or an input is missing; with the inputs that are found
    /// stored.
    fn attempt(
        &self,
        number: usize,
        owned: bool,
        unknown_inputs: &[usize],
    ) -> (Vec<usize>, Attempt) {
        let mut stored = Vec::new();
        // A stage of the worker's own share is probably missing: looking it up first would only
        // cost time.
        if !owned && self.is_stored(number) {
            lock(&self.cost).found += 1;
            return (stored, Attempt::Stored);
        }
        for &input in unknown_inputs {
            if !self.is_stored(input) {
                return (stored, Attempt::MissingInput);
            }
            stored.push(input);
        }
        (stored, self.lock_and_compute(number))
    }

    fn lock_and_compute(&self, number: usize) -> Attempt {
        let node = &self.graph.nodes[number];
        let Some(entry) = self.store.lock(node.kind.name, &node.key) else {
            lock(&self.cost).locks_lost += 1;
            return Attempt::Elsewhere;
        };
        let key = node.key.short();
        let event = StageEvent {
            number,
            stage: node.kind.name,
            label: &node.label,
            key: &key,
            cost_ms: node.cost_ms,
        };
        self.options.progress.started(event);
        if self.is_stored(number) {
            lock(&self.cost).found += 1;
            self.options.progress.finished(event, Timing::default(), None);
            self.release_inputs(number);
            return Attempt::Stored;
        }
        // A failure that is known, or inherited from an input, was reported when it happened.
        let inputs =
            self.options.record.find_failure(&node.key).map_or_else(|| self.inputs(node), Err);
        let (outcome, timing) = match inputs {
            Ok(inputs) => {
                let progress = self.options.progress.of_stage();
                let advanced = move |share| progress.advanced(number, share);
                let (computed, timing) =
                    timed(|| with_share_listener(advanced, || compute(node, &inputs)));
                let failure = computed.as_ref().err().map(|failure| failure.status.as_str());
                self.options.progress.finished(event, timing, failure);
                let stored = |(value, bytes)| {
                    self.send_result(Unwritten { number, bytes, timing, _entry: entry });
                    value
                };
                (computed.map(stored), Some(timing))
            }
            Err(failure) => {
                self.options.progress.finished(event, Timing::default(), None);
                (Err(failure), None)
            }
        };
        if let Err(failure) = &outcome {
            self.options.record.record_failure(&node.key, failure);
        }
        *lock(&self.timings[number]) = timing;
        self.keep(number, outcome);
        self.release_inputs(number);
        Attempt::Computed
    }

    fn is_stored(&self, number: usize) -> bool {
        let node = &self.graph.nodes[number];
        self.store.contains(node.kind.name, &node.key)
    }

    /// Stores a result: at once, or in the background where the run is shared.
    fn send_result(&self, result: Unwritten) {
        let writer = self.sharing.as_ref().and_then(|sharing| lock(&sharing.writer).clone());
        let Some(writer) = writer else { return self.store_result(result) };
        if let Err(SendError(result)) = writer.send(result) {
            self.store_result(result);
        }
    }

    fn store_result(&self, result: Unwritten) {
        let Unwritten { number, bytes, timing, _entry } = result;
        let node = &self.graph.nodes[number];
        if self.sharing.is_some() && self.is_stored(number) {
            // The lock did not keep another process from it: the bytes are the same.
            let mut cost = lock(&self.cost);
            (cost.duplicates, cost.duplicate_s) =
                (cost.duplicates + 1, cost.duplicate_s + timing.wall_s);
            return;
        }
        self.write(node, &bytes);
        let code = self.graph.code(number).to_string();
        self.store.note(
            node.kind.name,
            &node.key,
            &Note { label: node.label.clone(), code, timing, cost_ms: node.cost_ms },
        );
    }

    fn write(&self, node: &StageNode, bytes: &[u8]) {
        if let Err(error) = self.store.write(node.kind.name, &node.key, bytes)
            && !self.write_failed.swap(true, Ordering::Relaxed)
        {
            let root = self.store.root().display();
            let text = format!(
                "results cannot be kept in {root}: {error}; the run continues without storing them"
            );
            self.options.progress.notice(&text);
        }
    }

    /// Keeps a result in memory. One of several workers keeps the youngest only.
    fn keep(&self, number: usize, outcome: StageOutcome) {
        *lock(&self.values[number]) = Some(outcome);
        let Some(sharing) = &self.sharing else { return };
        let mut in_memory = lock(&sharing.in_memory);
        in_memory.push_back(number);
        if in_memory.len() > MAX_RESULTS_IN_MEMORY
            && let Some(oldest) = in_memory.pop_front()
        {
            lock(&self.values[oldest]).take_if(|outcome| outcome.is_ok());
        }
    }

    /// Drops inputs that no other stage will read.
    fn release_inputs(&self, number: usize) {
        for &input in &self.graph.nodes[number].inputs {
            if self.remaining_uses[input].fetch_sub(1, Ordering::AcqRel) == 1 {
                *lock(&self.values[input]) = None;
            }
        }
    }

    /// The results that a stage reads, or the first failure among them.
    fn inputs(&self, node: &StageNode) -> Result<InputResults, Failure> {
        let value = |&input: &usize| Ok((input, self.value(input)?));
        Ok(InputResults { results: node.inputs.iter().map(value).collect::<Result<_, _>>()? })
    }

    /// The result of a stage: from memory, from the store, or computed again where the stored one
    /// is damaged.
    fn value(&self, number: usize) -> StageOutcome {
        if let Some(outcome) = &*lock(&self.values[number]) {
            return outcome.clone();
        }
        let node = &self.graph.nodes[number];
        let outcome = match load(node, self.store, self.options.progress) {
            Some(value) => Ok(value),
            None => self
                .options
                .record
                .find_failure(&node.key)
                .map_or_else(|| self.compute_again(node), Err),
        };
        self.keep(number, outcome.clone());
        outcome
    }

    /// The result of a stage that was stored and is not, or is damaged.
    fn compute_again(&self, node: &StageNode) -> StageOutcome {
        let (value, bytes) = compute(node, &self.inputs(node)?)?;
        self.write(node, &bytes);
        Ok(value)
    }

    fn outcomes(self, cached: usize, wanted: &[usize]) -> Outcomes {
        let stopped =
            lock(&self.queue).unfinished() > 0 && self.options.stop.load(Ordering::Relaxed);
        if !stopped {
            // What other processes have stored meanwhile.
            wanted.iter().for_each(|&stage| drop(self.value(stage)));
        }
        let mut cost = inner(self.cost);
        cost.left = inner(self.queue).unfinished();
        let values = self.values.into_iter().map(inner).collect();
        let timings = self.timings.into_iter().map(inner).collect();
        Outcomes::new(values, timings, cached + cost.found, stopped, cost)
    }
}

/// Runs the stage; its result and the result's bytes. A panic in a stage is a defect, but it ends
/// that stage only.
fn compute(node: &StageNode, inputs: &InputResults) -> Result<(AnyResult, Vec<u8>), Failure> {
    let failed = |status: String| Failure { stage: node.kind.name.into(), status };
    let value = catch_unwind(AssertUnwindSafe(|| (node.job)(inputs)))
        .unwrap_or_else(|panic| Err(format!("panicked: {}", message(panic.as_ref()))))
        .map_err(failed)?;
    let bytes = (node.encode)(&value).map_err(|error| failed(error.to_string()))?;
    Ok((value, bytes))
}

/// The message of a panic.
fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without a message")
}

#[cfg(test)]
mod tests;
