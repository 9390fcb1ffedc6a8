use super::*;
use crate::runner::execute::plan::plan;
use crate::runner::execute::progress::Style;
use crate::runner::graph::stage::{Handle, Stage, StageInputs, StageKind};
use std::sync::Arc;

const KIND: StageKind =
    StageKind { name: "add", module: "spinebench::runner::jobs::data::path", cost_ms: 1 };

/// A number with a count of how often its stage ran.
#[derive(serde::Serialize)]
struct Counted {
    number: usize,
    #[serde(skip)]
    count: Arc<AtomicUsize>,
}

const ADD: Stage<Counted, Vec<Handle<u64>>, u64> = Stage {
    kind: KIND,
    job: |params, inputs| {
        params.count.fetch_add(1, Ordering::Relaxed);
        std::thread::sleep(Duration::from_micros(200));
        Ok(inputs.into_iter().sum::<u64>().max(1))
    },
};

/// A ladder of stages: number n adds the two before it; counts how often any ran.
fn ladder(count: Arc<AtomicUsize>) -> (Graph, Vec<Handle<u64>>) {
    let mut graph = Graph::default();
    let mut handles: Vec<Handle<u64>> = Vec::new();
    for number in 0..20_usize {
        let inputs = handles[number.saturating_sub(2)..].to_vec();
        let params = Counted { number, count: count.clone() };
        handles.push(graph.stage(&ADD, format!("{number}"), params, inputs).unwrap());
    }
    (graph, handles)
}

/// Adds a stage of this name with this job.
fn add<I: StageInputs>(
    graph: &mut Graph,
    name: &'static str,
    inputs: I,
    job: fn(&&'static str, I::Results<'_>) -> Result<u64, String>,
) -> Handle<u64> {
    graph.stage(&Stage { kind: KIND, job }, name, name, inputs).unwrap()
}

fn run(graph: &Graph, store: &Store, wanted: usize, threads: usize) -> Outcomes {
    execute(graph, store, &[wanted], &RunOptions::new(threads, &Progress::new(Style::Quiet)))
        .unwrap()
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
fn a_failure_reaches_only_the_stages_that_need_it() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::at(folder.path());
    let mut graph = Graph::default();
    let bad = add(&mut graph, "bad", (), |_, ()| Err("diverged".into()));
    let after = add(&mut graph, "after", bad, |_, bad| Ok(*bad));
    let good = add(&mut graph, "good", (), |_, ()| Ok(3));
    let done = execute(&graph, &store, &[1, 2], &RunOptions::new(2, &Progress::new(Style::Quiet)))
        .unwrap();
    assert_eq!(
        done.get(after).unwrap_err(),
        Failure { stage: "add".into(), status: "diverged".into() }
    );
    assert_eq!(*done.get(good).unwrap(), 3);
    assert_eq!(plan(&graph, &store, &[1, 2]), [Need::Compute, Need::Compute, Need::Cached]);
}

#[test]
fn a_store_that_cannot_be_written_does_not_stop_the_run() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let (graph, handles) = ladder(Arc::default());
    let done = run(&graph, &Store::at(folder.path().join("file")), 19, 2);
    assert_eq!(*done.get(handles[19]).unwrap(), 6765);
}

#[test]
fn runs_that_share_a_store_share_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let count = Arc::new(AtomicUsize::new(0));
    let (counts, results): (Vec<usize>, Vec<u64>) = std::thread::scope(|scope| {
        let run = || {
            let (graph, handles) = ladder(count.clone());
            let done = run(&graph, &Store::at(folder.path()), 19, 2);
            (done.computed, *done.get(handles[19]).unwrap())
        };
        let runs: Vec<_> = (0..3).map(|_| scope.spawn(run)).collect();
        runs.into_iter().map(|run| run.join().unwrap()).unzip()
    });
    assert_eq!(results, [6765; 3]);
    assert_eq!(
        (counts.iter().sum::<usize>(), count.load(Ordering::Relaxed)),
        (20, 20),
        "{counts:?}"
    );
}

#[test]
fn a_stopped_run_starts_no_further_stage_and_continues_later() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::at(folder.path());
    let count = Arc::new(AtomicUsize::new(0));
    let (graph, handles) = ladder(count.clone());
    let (stop, progress) = (AtomicBool::new(false), Progress::new(Style::Quiet));
    let options = RunOptions { stop: &stop, ..RunOptions::new(1, &progress) };
    let stopped = std::thread::scope(|scope| {
        scope.spawn(|| {
            while count.load(Ordering::Relaxed) < 5 {
                std::thread::yield_now();
            }
            stop.store(true, Ordering::Relaxed);
        });
        execute(&graph, &store, &[19], &options).unwrap()
    });
    let before = count.load(Ordering::Relaxed);
    assert!(stopped.stopped && stopped.computed == before && before < 20, "{before}");
    let done = run(&graph, &store, 19, 2);
    assert_eq!((*done.get(handles[19]).unwrap(), done.stopped), (6765, false));
    assert_eq!(count.load(Ordering::Relaxed), 20, "finished stages do not run again");
}

/// One stage that is known to fail.
struct Known(Key, Failure);

impl RunRecord for Known {
    fn find_failure(&self, key: &Key) -> Option<Failure> {
        (*key == self.0).then(|| self.1.clone())
    }
    fn record_failure(&self, _: &Key, _: &Failure) {}
    fn finished_shares(&self) -> Vec<usize> {
        Vec::new()
    }
    fn record_share(&self, _: usize) {}
}

#[test]
fn known_failures_are_not_tried_again_and_a_panic_keeps_its_message() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::at(folder.path());
    let mut graph = Graph::default();
    let bad = add(&mut graph, "bad", (), |_, ()| panic!("seven is not eight"));
    let done =
        execute(&graph, &store, &[0], &RunOptions::new(1, &Progress::new(Style::Quiet))).unwrap();
    assert_eq!(done.get(bad).unwrap_err().status, "panicked: seven is not eight");

    let failure = Failure { stage: "add".into(), status: "lost".into() };
    let known = Known(graph.describe(0).2, failure.clone());
    let progress = Progress::new(Style::Quiet);
    let options = RunOptions { record: &known, ..RunOptions::new(1, &progress) };
    let done = execute(&graph, &store, &[0], &options).unwrap();
    assert_eq!((done.get(bad).unwrap_err(), done.failure(0)), (failure.clone(), Some(&failure)));
}

#[test]
fn workers_share_what_is_missing_and_a_damaged_input_is_computed_again() {
    let folder = tempfile::tempdir().unwrap();
    let count = Arc::new(AtomicUsize::new(0));
    let store = Store::at(folder.path());
    let (graph, _) = ladder(count.clone());
    run(&graph, &store, 9, 1);
    let (name, _, key) = graph.describe(9);
    std::fs::write(store.path(name, &key), "rubbish").unwrap();
    let missing: Vec<usize> = (10..20).collect();
    let done: Vec<Outcomes> = std::thread::scope(|scope| {
        let work = |worker: usize| {
            let (missing, count, store) = (&missing, count.clone(), Store::at(folder.path()));
            scope.spawn(move || {
                let graph = ladder(count).0;
                let share = WorkerShare { worker, workers: 3, missing };
                execute_share(
                    &graph,
                    &store,
                    share,
                    &RunOptions::new(1, &Progress::new(Style::Quiet)),
                )
                .unwrap()
            })
        };
        let workers: Vec<_> = (0..3).map(work).collect();
        workers.into_iter().map(|worker| worker.join().unwrap()).collect()
    });
    assert_eq!(done.iter().map(|done| done.computed).sum::<usize>(), 10);
    // The damaged one again, by whoever read it first, at most by all three at once.
    let again = count.load(Ordering::Relaxed) - 20;
    assert!((1..=3).contains(&again), "{again} of the stored stages computed again");
    assert!(done.iter().all(|done| !done.stopped && done.sharing.duplicates == 0));
    assert!(done.iter().any(|done| done.sharing.left == 0), "the last one sees that all is done");
    assert!(matches!(store.read("add", &graph.describe(19).2), Lookup::Found(_)));
}
