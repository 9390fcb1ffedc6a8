//! Executes a graph: computes what is wanted and not stored, each stage as soon as its inputs exist, the stage with the
//! longest chain of dependent work first. Stages that another process computes are waited for.

use super::graph::{AnyResult, Failure, Graph, Inputs, StageNode};
use super::key::Key;
use super::outcomes::{Outcome, Outcomes};
use super::plan::{Need, plan_with};
use super::progress::{Progress, StageEvent};
use super::store::{LockAttempt, Lookup, Note, Store};
use super::timing::{Stopwatch, Timing};
use std::any::Any;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, LazyLock, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, available_parallelism};
use std::time::Duration;

/// Interval at which idle threads check for finished stages of other processes and for a stop request.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// How to execute a graph.
pub struct RunOptions<'a> {
    /// Number of threads; 0: one per processor.
    pub threads: usize,
    /// Receives what happens.
    pub progress: &'a Progress,
    /// Once true, no further stage starts; stages that have started end normally.
    pub stop: &'a AtomicBool,
    /// Stages that failed in another process; they are not tried again.
    pub known: &'a HashMap<Key, Failure>,
}

impl<'a> RunOptions<'a> {
    /// Options of a run that ends when all is done and that knows of no failures.
    pub fn new(threads: usize, progress: &'a Progress) -> RunOptions<'a> {
        static NEVER: AtomicBool = AtomicBool::new(false);
        static NONE: LazyLock<HashMap<Key, Failure>> = LazyLock::new(HashMap::new);
        RunOptions { threads, progress, stop: &NEVER, known: &NONE }
    }
}

/// Reads the `wanted` stages from the store or computes them.
///
/// # Errors
/// [`Failure`] when no thread can be started.
pub fn execute(graph: &Graph, store: &Store, wanted: &[usize], options: &RunOptions) -> Result<Outcomes, Failure> {
    let mut values: Vec<Option<Outcome>> = graph.nodes.iter().map(|_| None).collect();
    let needs = plan_with(graph, wanted, |number, node| {
        values[number] = load(node, store, Some(options.progress)).map(Ok);
        values[number].is_some()
    });
    let cached = needs.iter().filter(|&&need| need == Need::Cached).count();
    let workers = Workers::new(graph, store, options, values, &needs, wanted);
    let kinds = workers.todo().map(|number| graph.nodes[number].kind);
    options.progress.planned(kinds.map(|kind| (kind.name, kind.cost_ms)), cached);
    let threads = if options.threads == 0 { available_parallelism().map_or(1, usize::from) } else { options.threads };
    // Parts of stages share as many more; the first run of a process decides.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    let started = std::thread::scope(|scope| {
        let spawn =
            |number: usize| Builder::new().name(format!("stage {number}")).spawn_scoped(scope, || workers.work());
        (0..threads).map(spawn).filter_map(Result::ok).count()
    });
    if started == 0 {
        return Err(Failure { stage: "threads".into(), status: "none could be started".into() });
    }
    options.progress.done();
    Ok(workers.outcomes(cached))
}

/// Reads a stored result; `None` when there is none or it fails its checks, which `progress` reports.
fn load(node: &StageNode, store: &Store, progress: Option<&Progress>) -> Option<AnyResult> {
    let reason = match store.read(node.kind.name, &node.key) {
        Lookup::Absent => return None,
        Lookup::Found(bytes) => match (node.decode)(&bytes) {
            Ok(value) => return Some(value),
            Err(error) => error.to_string(),
        },
        Lookup::Damaged(reason) => reason,
    };
    if let Some(progress) = progress {
        progress.notice(&format!(
            "stored result {} {} is damaged ({reason}); computing it again",
            node.kind.name,
            node.key.short()
        ));
    }
    None
}

/// Stages that can run now.
struct ReadyQueue {
    /// With the cost of the chain behind each, the heaviest on top.
    ready: BinaryHeap<(u64, Reverse<usize>)>,
    /// Ready, but another process holds their locks.
    locked_elsewhere: Vec<usize>,
    /// Number of stages that have not ended, ready or not.
    remaining: usize,
}

/// State shared by the worker threads of a run. The workers are not a rayon pool: a rayon thread that waits for a part of
/// its stage may start another stage inside the first one, without limit.
struct Workers<'a> {
    graph: &'a Graph,
    store: &'a Store,
    options: &'a RunOptions<'a>,
    needs: &'a [Need],
    values: Vec<Mutex<Option<Outcome>>>,
    timings: Vec<Mutex<Option<Timing>>>,
    /// Number of inputs of each stage that are not computed yet.
    pending_inputs: Vec<AtomicUsize>,
    /// Remaining uses of each result; a wanted result counts one more, so that it stays in memory.
    uses: Vec<AtomicUsize>,
    /// Computed stages that ask for each stage.
    dependents: Vec<Vec<usize>>,
    /// Cost of the longest chain that begins with each stage.
    priority: Vec<u64>,
    queue: Mutex<ReadyQueue>,
    /// Signalled when stages become ready, and at the end.
    changed: Condvar,
    /// Number of stages that another process computed meanwhile.
    found: AtomicUsize,
    write_failure_reported: AtomicBool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Workers<'a> {
    fn new(
        graph: &'a Graph,
        store: &'a Store,
        options: &'a RunOptions,
        values: Vec<Option<Outcome>>,
        needs: &'a [Need],
        wanted: &[usize],
    ) -> Workers<'a> {
        let count = graph.nodes.len();
        let mut dependents = vec![Vec::new(); count];
        let mut priority = vec![0; count];
        for number in (0..count).rev().filter(|&number| needs[number] == Need::Compute) {
            let node = &graph.nodes[number];
            priority[number] += node.kind.cost_ms;
            for &input in &node.inputs {
                dependents[input].push(number);
                priority[input] = priority[input].max(priority[number]);
            }
        }
        let to_compute = |input: &&usize| needs[**input] == Need::Compute;
        let waits: Vec<usize> = graph.nodes.iter().map(|node| node.inputs.iter().filter(to_compute).count()).collect();
        let todo = || (0..count).filter(|&number| needs[number] == Need::Compute);
        let ready = todo().filter(|&number| waits[number] == 0).map(|number| (priority[number], Reverse(number)));
        let queue = ReadyQueue { ready: ready.collect(), locked_elsewhere: Vec::new(), remaining: todo().count() };
        let mut uses: Vec<usize> = dependents.iter().map(Vec::len).collect();
        wanted.iter().for_each(|&number| uses[number] += 1);
        Workers {
            graph,
            store,
            options,
            needs,
            pending_inputs: waits.into_iter().map(AtomicUsize::new).collect(),
            uses: uses.into_iter().map(AtomicUsize::new).collect(),
            values: values.into_iter().map(Mutex::new).collect(),
            timings: graph.nodes.iter().map(|_| Mutex::default()).collect(),
            dependents,
            priority,
            queue: Mutex::new(queue),
            changed: Condvar::new(),
            found: AtomicUsize::new(0),
            write_failure_reported: AtomicBool::new(false),
        }
    }

    fn todo(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.needs.len()).filter(|&number| self.needs[number] == Need::Compute)
    }

    /// Runs stages, the highest priority first, until none remains or a stop is requested.
    fn work(&self) {
        let mut queue = lock(&self.queue);
        while queue.remaining > 0 && !self.options.stop.load(Ordering::Relaxed) {
            let Some((_, Reverse(number))) = queue.ready.pop() else {
                queue = self.changed.wait_timeout(queue, POLL_INTERVAL).unwrap_or_else(PoisonError::into_inner).0;
                let again: Vec<usize> = queue.locked_elsewhere.drain(..).collect();
                queue.ready.extend(again.into_iter().map(|number| (self.priority[number], Reverse(number))));
                continue;
            };
            drop(queue);
            let ended = self.run_stage(number);
            queue = lock(&self.queue);
            if !ended {
                queue.locked_elsewhere.push(number);
                continue;
            }
            let waits = |&&next: &&usize| self.pending_inputs[next].fetch_sub(1, Ordering::AcqRel) == 1;
            let ready = self.dependents[number].iter().filter(waits);
            queue.ready.extend(ready.map(|&next| (self.priority[next], Reverse(next))));
            queue.remaining -= 1;
            self.changed.notify_all();
        }
    }

    /// Computes a stage, or finds it in the store; false where another process computes it.
    fn run_stage(&self, number: usize) -> bool {
        let node = &self.graph.nodes[number];
        let inputs = match self.options.known.get(&node.key) {
            Some(failure) => Err(failure.clone()),
            None => self.inputs(node),
        };
        let key = node.key.short();
        let event = StageEvent { stage: node.kind.name, label: &node.label, key: &key, cost_ms: node.kind.cost_ms };
        let inputs = match inputs {
            Ok(inputs) => inputs,
            Err(failure) => {
                // The failure was reported when it happened.
                self.options.progress.started(event);
                self.options.progress.finished(event, Timing::default(), None);
                self.finish(number, Err(failure), None);
                return true;
            }
        };
        let LockAttempt::Acquired(entry_lock) = self.store.try_lock(node.kind.name, &node.key) else { return false };
        self.options.progress.started(event);
        let stopwatch = Stopwatch::start();
        let (outcome, timing) = match load(node, self.store, None) {
            Some(value) => {
                self.found.fetch_add(1, Ordering::Relaxed);
                (Ok(value), None)
            }
            None => (self.compute(node, &inputs), Some(stopwatch.read())),
        };
        if let (Ok(_), Some(timing)) = (&outcome, timing) {
            let code = self.graph.code(number).to_string();
            self.store.note(node.kind.name, &node.key, &Note { label: node.label.clone(), code, timing });
        }
        drop(entry_lock);
        let failure = outcome.as_ref().err().map(|failure| failure.status.as_str());
        self.options.progress.finished(event, timing.unwrap_or_default(), failure);
        self.finish(number, outcome, timing);
        true
    }

    /// Stores the outcome of a stage and drops inputs that no other stage needs.
    fn finish(&self, number: usize, outcome: Outcome, timing: Option<Timing>) {
        *lock(&self.timings[number]) = timing;
        *lock(&self.values[number]) = Some(outcome);
        for &input in &self.graph.nodes[number].inputs {
            if self.uses[input].fetch_sub(1, Ordering::AcqRel) == 1 {
                *lock(&self.values[input]) = None;
            }
        }
    }

    /// The results that a stage reads, or the first failure among them.
    fn inputs(&self, node: &StageNode) -> Result<Inputs, Failure> {
        let missing = || Failure { stage: node.kind.name.into(), status: "an input is missing".into() };
        let value = |&input: &usize| match &*lock(&self.values[input]) {
            Some(Ok(value)) => Ok((input, value.clone())),
            Some(Err(failure)) => Err(failure.clone()),
            None => Err(missing()),
        };
        Ok(Inputs { values: node.inputs.iter().map(value).collect::<Result<_, _>>()? })
    }

    /// Runs the stage and stores its result. A panic in a stage is a defect, but it ends that stage only.
    fn compute(&self, node: &StageNode, inputs: &Inputs) -> Result<AnyResult, Failure> {
        let failed = |status: String| Failure { stage: node.kind.name.into(), status };
        let value = catch_unwind(AssertUnwindSafe(|| (node.job)(inputs)))
            .unwrap_or_else(|panic| Err(format!("panicked: {}", panic_message(panic.as_ref()))))
            .map_err(failed)?;
        let bytes = (node.encode)(&value).map_err(|error| failed(error.to_string()))?;
        if let Err(error) = self.store.write(node.kind.name, &node.key, &bytes)
            && !self.write_failure_reported.swap(true, Ordering::Relaxed)
        {
            let root = self.store.root().display();
            let text = format!("cannot store results in {root}: {error}; the run continues without storing");
            self.options.progress.notice(&text);
        }
        Ok(value)
    }

    fn outcomes(self, cached: usize) -> Outcomes {
        let stopped = lock(&self.queue).remaining > 0;
        let cached = cached + self.found.into_inner();
        let inner = |timing: Mutex<_>| timing.into_inner().unwrap_or_else(PoisonError::into_inner);
        let values = self.values.into_iter().map(|value| value.into_inner().unwrap_or_else(PoisonError::into_inner));
        Outcomes::new(values.collect(), self.timings.into_iter().map(inner).collect(), cached, stopped)
    }
}

/// The message of a panic.
fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message")
}

#[cfg(test)]
mod tests;
