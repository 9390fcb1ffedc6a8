//! Carries out a graph: what is wanted and not stored is computed, each stage as soon as its inputs are there, the
//! one with the longest chain of work behind it first. What another process computes meanwhile is waited for.

use super::graph::{Failure, Graph, Inputs, Node, Value};
use super::key::Key;
use super::outcomes::{Outcome, Outcomes};
use super::progress::{Progress, Told};
use super::store::{Claimed, Lookup, Note, Store};
use super::survey::{Need, backwards};
use super::timing::{Stopwatch, Timing};
use std::any::Any;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, available_parallelism};
use std::time::Duration;

/// How often threads without work look whether others are done, or whether they shall stop.
const LOOK: Duration = Duration::from_millis(50);

/// How a graph is carried out.
pub struct Orders<'a> {
    /// Threads; 0: one a processor.
    pub threads: usize,
    /// Whom it is told to.
    pub progress: &'a Progress,
    /// Once true, no stage is begun any more; those under way are ended.
    pub stop: &'a AtomicBool,
    /// Stages that are known to fail, as another process found out; they are not tried again.
    pub known: &'a HashMap<Key, Failure>,
}

/// Computes or reads the `wanted` stages on `threads` threads (0: one a processor).
///
/// # Errors
/// When the threads cannot be started.
pub fn execute(
    graph: &Graph,
    store: &Store,
    wanted: &[usize],
    threads: usize,
    progress: &Progress,
) -> Result<Outcomes, Failure> {
    let (stop, known) = (AtomicBool::new(false), HashMap::new());
    carry_out(graph, store, wanted, &Orders { threads, progress, stop: &stop, known: &known })
}

/// Computes or reads the `wanted` stages.
///
/// # Errors
/// When the threads cannot be started.
pub fn carry_out(graph: &Graph, store: &Store, wanted: &[usize], orders: &Orders) -> Result<Outcomes, Failure> {
    let mut values: Vec<Option<Outcome>> = graph.nodes.iter().map(|_| None).collect();
    let needs = backwards(graph, wanted, |number, node| {
        values[number] = load(node, store, Some(orders.progress)).map(Ok);
        values[number].is_some()
    });
    let cached = needs.iter().filter(|&&need| need == Need::Cached).count();
    let crew = Crew::new(graph, store, orders, values, &needs, wanted);
    let kinds = crew.todo().map(|number| graph.nodes[number].kind);
    orders.progress.planned(kinds.map(|kind| (kind.name, kind.cost_ms)), cached);
    let threads = if orders.threads == 0 { available_parallelism().map_or(1, usize::from) } else { orders.threads };
    // Parts of stages share as many more; the first run of a process decides.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    let started = std::thread::scope(|scope| {
        let spawn = |number: usize| Builder::new().name(format!("stage {number}")).spawn_scoped(scope, || crew.work());
        (0..threads).map(spawn).filter_map(Result::ok).count()
    });
    if started == 0 {
        return Err(Failure { stage: "threads".into(), status: "none could be started".into() });
    }
    orders.progress.done();
    Ok(crew.outcomes(cached))
}

/// Reads a stored result; `None` when there is none or it fails its checks, which is told.
fn load(node: &Node, store: &Store, told: Option<&Progress>) -> Option<Value> {
    let reason = match store.read(node.kind.name, &node.key) {
        Lookup::Absent => return None,
        Lookup::Found(bytes) => match (node.decode)(&bytes) {
            Ok(value) => return Some(value),
            Err(error) => error.to_string(),
        },
        Lookup::Damaged(reason) => reason,
    };
    if let Some(progress) = told {
        progress.notice(&format!(
            "stored result {} {} is damaged ({reason}); computing it again",
            node.kind.name,
            node.key.short()
        ));
    }
    None
}

/// Stages that can be carried out now.
struct Queue {
    /// With the cost of the chain behind each, the heaviest on top.
    ready: BinaryHeap<(u64, Reverse<usize>)>,
    /// Ready, but another process has claimed them.
    elsewhere: Vec<usize>,
    /// Stages that have not been carried out, ready or not.
    left: usize,
}

/// The threads' shared view of a run. They are no pool of rayon's: a thread that waits there for a part of its stage may
/// begin another stage meanwhile, within the first, and another within that.
struct Crew<'a> {
    graph: &'a Graph,
    store: &'a Store,
    orders: &'a Orders<'a>,
    needs: &'a [Need],
    values: Vec<Mutex<Option<Outcome>>>,
    timings: Vec<Mutex<Option<Timing>>>,
    /// Inputs of each stage that are still to be computed.
    waits: Vec<AtomicUsize>,
    /// Uses of each result that are still to come; a wanted one counts one more, so that it stays.
    uses: Vec<AtomicUsize>,
    /// Computed stages that ask for each stage.
    dependents: Vec<Vec<usize>>,
    /// Cost of the longest chain that begins with each stage.
    priority: Vec<u64>,
    queue: Mutex<Queue>,
    /// Told when stages have become ready, and at the end.
    news: Condvar,
    /// Stages that were found in the store after all: another process has computed them.
    found: AtomicUsize,
    store_told: AtomicBool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Crew<'a> {
    fn new(
        graph: &'a Graph,
        store: &'a Store,
        orders: &'a Orders,
        values: Vec<Option<Outcome>>,
        needs: &'a [Need],
        wanted: &[usize],
    ) -> Crew<'a> {
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
        let queue = Queue { ready: ready.collect(), elsewhere: Vec::new(), left: todo().count() };
        let mut uses: Vec<usize> = dependents.iter().map(Vec::len).collect();
        wanted.iter().for_each(|&number| uses[number] += 1);
        Crew {
            graph,
            store,
            orders,
            needs,
            waits: waits.into_iter().map(AtomicUsize::new).collect(),
            uses: uses.into_iter().map(AtomicUsize::new).collect(),
            values: values.into_iter().map(Mutex::new).collect(),
            timings: graph.nodes.iter().map(|_| Mutex::default()).collect(),
            dependents,
            priority,
            queue: Mutex::new(queue),
            news: Condvar::new(),
            found: AtomicUsize::new(0),
            store_told: AtomicBool::new(false),
        }
    }

    fn todo(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.needs.len()).filter(|&number| self.needs[number] == Need::Compute)
    }

    /// Carries out stages, the heaviest first, until none is left or somebody says stop.
    fn work(&self) {
        let mut queue = lock(&self.queue);
        while queue.left > 0 && !self.orders.stop.load(Ordering::Relaxed) {
            let Some((_, Reverse(number))) = queue.ready.pop() else {
                queue = self.news.wait_timeout(queue, LOOK).unwrap_or_else(PoisonError::into_inner).0;
                let again: Vec<usize> = queue.elsewhere.drain(..).collect();
                queue.ready.extend(again.into_iter().map(|number| (self.priority[number], Reverse(number))));
                continue;
            };
            drop(queue);
            let ended = self.carry_out(number);
            queue = lock(&self.queue);
            if !ended {
                queue.elsewhere.push(number);
                continue;
            }
            let waits = |&&next: &&usize| self.waits[next].fetch_sub(1, Ordering::AcqRel) == 1;
            let ready = self.dependents[number].iter().filter(waits);
            queue.ready.extend(ready.map(|&next| (self.priority[next], Reverse(next))));
            queue.left -= 1;
            self.news.notify_all();
        }
    }

    /// Computes a stage, or finds that it is done; false where another process is at it.
    fn carry_out(&self, number: usize) -> bool {
        let node = &self.graph.nodes[number];
        let inputs = match self.orders.known.get(&node.key) {
            Some(failure) => Err(failure.clone()),
            None => self.inputs(node),
        };
        let key = node.key.short();
        let told = Told { stage: node.kind.name, label: &node.label, key: &key, cost_ms: node.kind.cost_ms };
        let inputs = match inputs {
            Ok(inputs) => inputs,
            Err(failure) => {
                // The failure was told when it happened.
                self.orders.progress.started(told);
                self.orders.progress.finished(told, Timing::default(), None);
                self.ended(number, Err(failure), None);
                return true;
            }
        };
        let Claimed::Ours(claim) = self.store.claim(node.kind.name, &node.key) else { return false };
        self.orders.progress.started(told);
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
        drop(claim);
        let failure = outcome.as_ref().err().map(|failure| failure.status.as_str());
        self.orders.progress.finished(told, timing.unwrap_or_default(), failure);
        self.ended(number, outcome, timing);
        true
    }

    /// Files what became of a stage, and lets go of inputs that nobody else will ask for.
    fn ended(&self, number: usize, outcome: Outcome, timing: Option<Timing>) {
        *lock(&self.timings[number]) = timing;
        *lock(&self.values[number]) = Some(outcome);
        for &input in &self.graph.nodes[number].inputs {
            if self.uses[input].fetch_sub(1, Ordering::AcqRel) == 1 {
                *lock(&self.values[input]) = None;
            }
        }
    }

    /// The results that a stage asked for, or the first failure among them.
    fn inputs(&self, node: &Node) -> Result<Inputs, Failure> {
        let missing = || Failure { stage: node.kind.name.into(), status: "an input is missing".into() };
        let value = |&input: &usize| match &*lock(&self.values[input]) {
            Some(Ok(value)) => Ok((input, value.clone())),
            Some(Err(failure)) => Err(failure.clone()),
            None => Err(missing()),
        };
        Ok(Inputs { values: node.inputs.iter().map(value).collect::<Result<_, _>>()? })
    }

    /// Runs the stage and files its result. A panic in a stage is a defect, but it ends that stage only.
    fn compute(&self, node: &Node, inputs: &Inputs) -> Result<Value, Failure> {
        let failed = |status: String| Failure { stage: node.kind.name.into(), status };
        let value = catch_unwind(AssertUnwindSafe(|| (node.job)(inputs)))
            .unwrap_or_else(|panic| Err(format!("panicked: {}", words(panic.as_ref()))))
            .map_err(failed)?;
        let bytes = (node.encode)(&value).map_err(|error| failed(error.to_string()))?;
        if let Err(error) = self.store.write(node.kind.name, &node.key, &bytes)
            && !self.store_told.swap(true, Ordering::Relaxed)
        {
            let root = self.store.root().display();
            let text = format!("results cannot be kept in {root}: {error}; the run goes on without");
            self.orders.progress.notice(&text);
        }
        Ok(value)
    }

    fn outcomes(self, cached: usize) -> Outcomes {
        let stopped = lock(&self.queue).left > 0;
        let cached = cached + self.found.into_inner();
        let inner = |timing: Mutex<_>| timing.into_inner().unwrap_or_else(PoisonError::into_inner);
        let values = self.values.into_iter().map(|value| value.into_inner().unwrap_or_else(PoisonError::into_inner));
        Outcomes::new(values.collect(), self.timings.into_iter().map(inner).collect(), cached, stopped)
    }
}

/// What a panic said.
fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("it said nothing")
}

#[cfg(test)]
mod tests;
