//! Carries out a graph: what is wanted and not stored is computed, each stage as soon as its inputs are there, the
//! one with the longest chain of work behind it first.

use super::graph::{Artifact, Failure, Graph, Handle, Inputs, Node, Value};
use super::progress::{Progress, Told};
use super::store::{Lookup, Store};
use super::timing::{Stopwatch, Timing};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, available_parallelism};

type Outcome = Result<Value, Failure>;

/// What became of the stages that were wanted, and of those computed for them.
pub struct Outcomes {
    values: Vec<Option<Outcome>>,
    /// Time of each computed stage; `None` for those read from the store or not needed.
    pub timings: Vec<Option<Timing>>,
    /// Stages computed now.
    pub computed: usize,
    /// Stages read from the store.
    pub cached: usize,
    /// Failures of stages that were carried out, in the order of the graph.
    pub failures: Vec<Failure>,
}

impl Outcomes {
    /// The result of a wanted stage.
    ///
    /// # Errors
    /// The failure of the stage or of one before it.
    pub fn get<T: Artifact>(&self, handle: Handle<T>) -> Result<&T, Failure> {
        let missing = || Failure { stage: "runner".into(), status: format!("stage {} was not wanted", handle.node) };
        match self.values.get(handle.node).and_then(Option::as_ref) {
            Some(Ok(value)) => value.downcast_ref::<T>().ok_or_else(missing),
            Some(Err(failure)) => Err(failure.clone()),
            None => Err(missing()),
        }
    }
}

/// What a run would do with a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// Nothing: no stage that must be computed asks for it.
    None,
    /// Read it from the store.
    Cached,
    /// Compute it.
    Compute,
}

/// What is needed for the `wanted` stages, judging by the entries that the store has, without reading them.
pub fn survey(graph: &Graph, store: &Store, wanted: &[usize]) -> Vec<Need> {
    backwards(graph, wanted, |_, node| store.contains(node.kind.name, &node.key))
}

/// Decides for each stage from the last to the first: `stored` is asked only for those that are needed.
fn backwards(graph: &Graph, wanted: &[usize], mut stored: impl FnMut(usize, &Node) -> bool) -> Vec<Need> {
    let mut asked = vec![false; graph.nodes.len()];
    wanted.iter().for_each(|&node| asked[node] = true);
    let mut needs = vec![Need::None; graph.nodes.len()];
    for (number, node) in graph.nodes.iter().enumerate().rev() {
        if asked[number] {
            needs[number] = if stored(number, node) { Need::Cached } else { Need::Compute };
            if needs[number] == Need::Compute {
                node.inputs.iter().for_each(|&input| asked[input] = true);
            }
        }
    }
    needs
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
    let mut values: Vec<Option<Outcome>> = graph.nodes.iter().map(|_| None).collect();
    let needs = backwards(graph, wanted, |number, node| {
        values[number] = load(node, store, progress).map(Ok);
        values[number].is_some()
    });
    let cached = needs.iter().filter(|&&need| need == Need::Cached).count();
    let crew = Crew::new(graph, store, progress, values, &needs, wanted);
    let cost_ms = crew.todo().map(|number| graph.nodes[number].kind.cost_ms).sum();
    progress.planned(crew.todo().count(), cached, cost_ms);
    let threads = if threads == 0 { available_parallelism().map_or(1, usize::from) } else { threads };
    // Parts of stages share as many more; the first run of a process decides.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    let started = std::thread::scope(|scope| {
        let spawn = |number: usize| Builder::new().name(format!("stage {number}")).spawn_scoped(scope, || crew.work());
        (0..threads).map(spawn).filter_map(Result::ok).count()
    });
    if started == 0 {
        return Err(Failure { stage: "threads".into(), status: "none could be started".into() });
    }
    progress.done();
    Ok(crew.outcomes(cached))
}

/// Reads a stored result; `None` when there is none or it fails its checks, which is told.
fn load(node: &Node, store: &Store, progress: &Progress) -> Option<Value> {
    let reason = match store.read(node.kind.name, &node.key) {
        Lookup::Absent => return None,
        Lookup::Found(bytes) => match (node.decode)(&bytes) {
            Ok(value) => return Some(value),
            Err(error) => error.to_string(),
        },
        Lookup::Damaged(reason) => reason,
    };
    progress.notice(&format!(
        "stored result {} {} is damaged ({reason}); computing it again",
        node.kind.name,
        node.key.short()
    ));
    None
}

/// Stages that can be carried out now.
struct Queue {
    /// With the cost of the chain behind each, the heaviest on top.
    ready: BinaryHeap<(u64, Reverse<usize>)>,
    /// Stages that have not been carried out, ready or not.
    left: usize,
}

/// The threads' shared view of a run. They are no pool of rayon's: a thread that waits there for a part of its stage may
/// begin another stage meanwhile, within the first, and another within that.
struct Crew<'a> {
    graph: &'a Graph,
    store: &'a Store,
    progress: &'a Progress,
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
    store_told: AtomicBool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Crew<'a> {
    fn new(
        graph: &'a Graph,
        store: &'a Store,
        progress: &'a Progress,
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
        let queue = Queue { ready: ready.collect(), left: todo().count() };
        let uses = dependents.iter().enumerate();
        let uses = uses.map(|(number, list)| AtomicUsize::new(list.len() + usize::from(wanted.contains(&number))));
        Crew {
            graph,
            store,
            progress,
            needs,
            waits: waits.into_iter().map(AtomicUsize::new).collect(),
            uses: uses.collect(),
            values: values.into_iter().map(Mutex::new).collect(),
            timings: graph.nodes.iter().map(|_| Mutex::default()).collect(),
            dependents,
            priority,
            queue: Mutex::new(queue),
            news: Condvar::new(),
            store_told: AtomicBool::new(false),
        }
    }

    fn todo(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.needs.len()).filter(|&number| self.needs[number] == Need::Compute)
    }

    /// Carries out stages, the heaviest first, until none is left.
    fn work(&self) {
        let mut queue = lock(&self.queue);
        while queue.left > 0 {
            let Some((_, Reverse(number))) = queue.ready.pop() else {
                queue = self.news.wait(queue).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            drop(queue);
            self.carry_out(number);
            queue = lock(&self.queue);
            let waits = |&&next: &&usize| self.waits[next].fetch_sub(1, Ordering::AcqRel) == 1;
            let ready = self.dependents[number].iter().filter(waits);
            queue.ready.extend(ready.map(|&next| (self.priority[next], Reverse(next))));
            queue.left -= 1;
            self.news.notify_all();
        }
    }

    fn carry_out(&self, number: usize) {
        let node = &self.graph.nodes[number];
        let key = node.key.short();
        let told = Told { stage: node.kind.name, label: &node.label, key: &key, cost_ms: node.kind.cost_ms };
        self.progress.started(told);
        let stopwatch = Stopwatch::start();
        let outcome = match self.inputs(node) {
            Ok(inputs) => {
                let outcome = self.compute(node, &inputs);
                let failure = outcome.as_ref().err().map(|failure| failure.status.as_str());
                self.progress.finished(told, stopwatch.read(), failure);
                outcome
            }
            // The failure was told when it happened.
            Err(failure) => {
                self.progress.finished(told, stopwatch.read(), None);
                Err(failure)
            }
        };
        let timing = stopwatch.read();
        if outcome.is_ok() {
            self.store.note_timing(node.kind.name, &node.key, &timing);
        }
        *lock(&self.timings[number]) = Some(timing);
        *lock(&self.values[number]) = Some(outcome);
        for &input in &node.inputs {
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
            .unwrap_or_else(|_| Err("panicked".into()))
            .map_err(failed)?;
        let bytes = (node.encode)(&value).map_err(|error| failed(error.to_string()))?;
        if let Err(error) = self.store.write(node.kind.name, &node.key, &bytes)
            && !self.store_told.swap(true, Ordering::Relaxed)
        {
            let root = self.store.root().display();
            self.progress.notice(&format!("results cannot be kept in {root}: {error}; the run goes on without"));
        }
        Ok(value)
    }

    fn outcomes(self, cached: usize) -> Outcomes {
        let computed = self.todo().count();
        let values: Vec<Option<Outcome>> =
            self.values.into_iter().map(|value| value.into_inner().unwrap_or_else(PoisonError::into_inner)).collect();
        let timings =
            self.timings.into_iter().map(|timing| timing.into_inner().unwrap_or_else(PoisonError::into_inner));
        let failures = values.iter().filter_map(|value| value.as_ref()?.as_ref().err());
        let mut told: Vec<Failure> = Vec::new();
        failures.for_each(|failure| told.extend((!told.contains(failure)).then(|| failure.clone())));
        let failures = told;
        Outcomes { failures, timings: timings.collect(), computed, cached, values }
    }
}

#[cfg(test)]
mod tests {
    use super::super::graph::Kind;
    use super::super::progress::Style;
    use super::*;
    use std::sync::Arc;
    use std::time::Duration;

    const KIND: Kind = Kind { name: "add", version: 1, cost_ms: 1 };

    /// A ladder of stages: number n adds the two before it; counts how often any was carried out.
    fn ladder(count: Arc<AtomicUsize>) -> (Graph, Vec<Handle<u64>>) {
        let mut graph = Graph::default();
        let mut handles: Vec<Handle<u64>> = Vec::new();
        for number in 0..20_usize {
            let (inputs, count) = (handles[number.saturating_sub(2)..].to_vec(), count.clone());
            let numbers: Vec<usize> = inputs.iter().map(|handle| handle.node).collect();
            let stage = graph.stage(KIND, format!("{number}"), &number, &numbers, move |given| {
                count.fetch_add(1, Ordering::Relaxed);
                std::thread::sleep(Duration::from_micros(200));
                inputs.iter().try_fold(0_u64, |sum, input| Ok(sum + given.get(*input)?)).map(|sum| sum.max(1))
            });
            handles.push(stage.unwrap());
        }
        (graph, handles)
    }

    fn run(graph: &Graph, store: &Store, wanted: usize, threads: usize) -> Outcomes {
        execute(graph, store, &[wanted], threads, &Progress::new(Style::Quiet)).unwrap()
    }

    #[test]
    fn computed_once_then_read_and_recomputed_when_damaged() {
        let folder = tempfile::tempdir().unwrap();
        for threads in [1, 2, 8] {
            let store = Store::at(folder.path().join(threads.to_string()));
            let count = Arc::new(AtomicUsize::new(0));
            let (graph, handles) = ladder(count.clone());
            let last = handles[19];
            assert_eq!(*run(&graph, &store, 19, threads).get(last).unwrap(), 6765);
            assert_eq!(count.swap(0, Ordering::Relaxed), 20);

            let again = run(&graph, &store, 19, threads);
            assert_eq!((*again.get(last).unwrap(), again.computed, again.cached), (6765, 0, 1));

            let (name, _, key) = graph.describe(19);
            std::fs::write(store.path(name, &key), "rubbish").unwrap();
            let third = run(&graph, &store, 19, threads);
            assert_eq!((*third.get(last).unwrap(), third.computed, third.cached), (6765, 1, 2));
            assert_eq!(count.load(Ordering::Relaxed), 1);
            assert!(matches!(store.read(name, &key), Lookup::Found(_)));
        }
    }

    #[test]
    fn a_failure_reaches_those_that_need_it_and_nobody_else() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path());
        let mut graph = Graph::default();
        let bad: Handle<u64> = graph.stage(KIND, "bad", &"bad", &[], |_| Err("diverged".into())).unwrap();
        let after: Handle<u64> =
            graph.stage(KIND, "after", &"after", &[0], move |given| given.get(bad).copied()).unwrap();
        let good: Handle<u64> = graph.stage(KIND, "good", &"good", &[], |_| Ok(3)).unwrap();
        let done = execute(&graph, &store, &[1, 2], 2, &Progress::new(Style::Quiet)).unwrap();
        assert_eq!(done.get(after).unwrap_err(), Failure { stage: "add".into(), status: "diverged".into() });
        assert_eq!(*done.get(good).unwrap(), 3);
        assert_eq!(survey(&graph, &store, &[1, 2]), [Need::Compute, Need::Compute, Need::Cached]);
    }

    #[test]
    fn a_store_that_takes_nothing_does_not_stop_the_run() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("file"), "").unwrap();
        let (graph, handles) = ladder(Arc::default());
        let done = run(&graph, &Store::at(folder.path().join("file")), 19, 2);
        assert_eq!(*done.get(handles[19]).unwrap(), 6765);
    }
}
