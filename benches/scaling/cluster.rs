//! A cluster on paper: the workers of the Slurm executor, event by event, on recorded stage times.

use crate::recorded::Recorded;
use spinebench::runner::slurm::workers_per_task;
use spinebench::runner::{
    Campaign, EXCHANGE_INTERVAL, Graph, MAX_PAUSE, MAX_RESULTS_IN_MEMORY, MAX_RESUMED_STAGES,
    MAX_UNWRITTEN_RESULTS, MIN_PAUSE, Need, StageQueue, WorkPlan,
};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet, VecDeque};

/// What is assumed of the cluster.
pub struct Assumed {
    /// From the moment that a node is free to the first stage: launch, start of the program,
    /// expansion of the specs, s.
    pub begin_s: f64,
    /// From the start of an array task to that of all its workers, s.
    pub step_s: f64,
    /// Array tasks that the scheduler starts in a second.
    pub launches_per_s: f64,
    /// What the shared store delivers to all nodes together, bytes a second.
    pub store_bytes_s: f64,
    /// Time of one operation of the store: look up, lock, unlock, open or file an entry, s.
    pub store_operation_s: f64,
}

impl Default for Assumed {
    /// A scheduler as measured on the emulated one of `tests/program/slurm.rs`, a store behind one
    /// 10-gigabit line.
    fn default() -> Self {
        Assumed {
            begin_s: 1.0,
            step_s: 0.5,
            launches_per_s: 50.0,
            store_bytes_s: 1.0e9,
            store_operation_s: 0.005,
        }
    }
}

/// What each stage takes and how large its result is.
pub struct Costs {
    pub stage_s: Vec<f64>,
    pub bytes: Vec<f64>,
}

impl Costs {
    pub fn new(graph: &Graph, recorded: &Recorded) -> Costs {
        let kind = |stage: usize| graph.describe(stage).0;
        Costs {
            stage_s: (0..graph.len()).map(|stage| recorded.wall_s(kind(stage), stage)).collect(),
            bytes: (0..graph.len()).map(|stage| recorded.bytes(kind(stage))).collect(),
        }
    }
}

/// How a replayed campaign went.
#[derive(Default)]
pub struct Replayed {
    pub wall_s: f64,
    pub bytes: f64,
    pub operations: u64,
    pub locks_lost: u64,
    pub polls: u64,
    /// Time of all workers before their first stage, in the store, and without work, s.
    pub starting_s: f64,
    pub store_s: f64,
    pub idle_s: f64,
}

/// Replays a campaign on `nodes` nodes of one processor, a worker on each.
pub fn replay(campaign: &Campaign, costs: &Costs, assumed: &Assumed, nodes: usize) -> Replayed {
    let graph = &campaign.graph;
    let plan = WorkPlan::new(graph, &vec![Need::Compute; graph.len()], nodes);
    let mut cluster = Cluster {
        graph,
        costs,
        assumed,
        stored: vec![false; graph.len()],
        locked: vec![false; graph.len()],
        line_free_us: 0,
        finished: Vec::new(),
        left: graph.len(),
        workers: (0..nodes).map(|worker| Worker::new(StageQueue::new(&plan, worker))).collect(),
        events: BinaryHeap::new(),
        replayed: Replayed::default(),
    };
    cluster.run();
    cluster.replayed
}

/// What a worker does next. Each step ends with an operation of the store or a stage.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Step {
    Start,
    Take,
    /// A thread without work asks again.
    Resume,
    /// It knows whether the stage of another share is stored.
    LookedUp(usize),
    /// It knows whether this input of the stage is stored.
    LookedUpInput(usize, usize),
    /// It knows which shares are finished.
    Exchanged,
    /// Its attempt at the lock ends.
    Lock(usize),
    /// It has the lock, and knows whether the stage is stored meanwhile or has read an input.
    Locked(usize),
    Computed(usize),
    /// The lock of a stage that somebody else has stored is given back.
    Skipped(usize),
    /// In the background: the oldest result is about to be written, is stored, and its lock is
    /// given back.
    Write,
    Written,
    Unlocked,
}

/// One worker, and the results that it has in memory.
struct Worker<'a> {
    queue: StageQueue<'a>,
    pause_us: u64,
    held: HashSet<usize>,
    oldest: VecDeque<usize>,
    /// Results that are being written, the oldest first.
    unwritten: VecDeque<usize>,
    /// Waits until fewer results are unwritten.
    blocked: bool,
    exchanged_us: u64,
    recorded: bool,
}

impl<'a> Worker<'a> {
    fn new(queue: StageQueue<'a>) -> Worker<'a> {
        Worker {
            queue,
            pause_us: micros(MIN_PAUSE.as_secs_f64()),
            held: HashSet::new(),
            oldest: VecDeque::new(),
            unwritten: VecDeque::new(),
            blocked: false,
            exchanged_us: 0,
            recorded: false,
        }
    }

    fn computed(&mut self, stage: usize) {
        self.queue.mark_computed(stage);
        self.pause_us = micros(MIN_PAUSE.as_secs_f64());
    }

    fn found(&mut self, stage: usize) {
        self.queue.mark_stored(stage);
        self.pause_us = micros(MIN_PAUSE.as_secs_f64());
    }

    fn hold(&mut self, stage: usize) {
        if self.held.insert(stage) {
            self.oldest.push_back(stage);
        }
        if self.oldest.len() > MAX_RESULTS_IN_MEMORY
            && let Some(oldest) = self.oldest.pop_front()
        {
            self.held.remove(&oldest);
        }
    }
}

struct Cluster<'a> {
    graph: &'a Graph,
    costs: &'a Costs,
    assumed: &'a Assumed,
    stored: Vec<bool>,
    locked: Vec<bool>,
    /// When the store's line is free, microseconds.
    line_free_us: u64,
    /// Shares that their workers have recorded as finished.
    finished: Vec<usize>,
    left: usize,
    workers: Vec<Worker<'a>>,
    events: BinaryHeap<Reverse<(u64, usize, Step)>>,
    replayed: Replayed,
}

fn micros(seconds: f64) -> u64 {
    (seconds * 1e6) as u64
}

impl Cluster<'_> {
    fn run(&mut self) {
        let each = workers_per_task(self.workers.len());
        for worker in 0..self.workers.len() {
            let launched_s = (worker / each) as f64 / self.assumed.launches_per_s;
            let started_s = launched_s + self.assumed.begin_s + self.assumed.step_s;
            self.events.push(Reverse((micros(started_s), worker, Step::Start)));
        }
        while self.left > 0
            && let Some(Reverse((now_us, worker, step))) = self.events.pop()
        {
            self.replayed.wall_s = now_us as f64 * 1e-6;
            self.step(now_us, worker, step);
        }
    }

    fn step(&mut self, now_us: u64, number: usize, step: Step) {
        let worker = &mut self.workers[number];
        match step {
            Step::Start => {
                // The list of missing stages, some six bytes each.
                let end_us = self.read(now_us, 6.0 * self.graph.len() as f64);
                self.replayed.starting_s += end_us as f64 * 1e-6;
                self.then(end_us, number, Step::Take);
            }
            Step::Resume => {
                self.replayed.polls += u64::from(worker.queue.resume(MAX_RESUMED_STAGES) > 0);
                self.take(now_us, number);
            }
            Step::Take => self.take(now_us, number),
            Step::LookedUp(stage) if self.stored[stage] => {
                worker.found(stage);
                self.take(now_us, number);
            }
            Step::LookedUp(stage) => self.look_up_inputs(now_us, number, stage),
            Step::LookedUpInput(stage, input) if self.stored[input] => {
                worker.queue.mark_stored(input);
                self.look_up_inputs(now_us, number, stage);
            }
            Step::LookedUpInput(stage, _) => {
                worker.queue.wait_for_inputs(stage);
                self.take(now_us, number);
            }
            Step::Exchanged => {
                self.finished.iter().for_each(|&share| worker.queue.mark_share_stored(share));
                self.take_next(now_us, number);
            }
            Step::Lock(stage) if self.locked[stage] => {
                self.replayed.locks_lost += 1;
                worker.queue.postpone(stage);
                self.take(now_us, number);
            }
            Step::Lock(stage) => {
                self.locked[stage] = true;
                self.operate(now_us, number, Step::Locked(stage));
            }
            Step::Locked(stage) if self.stored[stage] => {
                self.operate(now_us, number, Step::Skipped(stage))
            }
            Step::Locked(stage) => self.compute(now_us, number, stage),
            Step::Computed(stage) => {
                worker.hold(stage);
                worker.unwritten.push_back(stage);
                worker.computed(stage);
                worker.blocked = worker.unwritten.len() > MAX_UNWRITTEN_RESULTS;
                let (blocked, alone) = (worker.blocked, worker.unwritten.len() == 1);
                if alone {
                    self.background(now_us, number, 1, Step::Write);
                }
                if !blocked {
                    self.take(now_us, number);
                }
            }
            Step::Skipped(stage) => {
                self.locked[stage] = false;
                worker.found(stage);
                self.take(now_us, number);
            }
            Step::Write => {
                let bytes = self.costs.bytes[worker.unwritten[0]];
                let moved_us = self.line(now_us, bytes);
                self.background(moved_us, number, 1, Step::Written);
            }
            Step::Written => {
                self.stored[worker.unwritten[0]] = true;
                self.left -= 1;
                // The note and the lock.
                self.background(now_us, number, 2, Step::Unlocked);
            }
            Step::Unlocked => {
                let stage = worker.unwritten.pop_front().expect("one is being written");
                self.locked[stage] = false;
                let (blocked, more) =
                    (std::mem::take(&mut worker.blocked), !worker.unwritten.is_empty());
                if more {
                    self.background(now_us, number, 1, Step::Write);
                }
                if blocked {
                    self.take(now_us, number);
                }
            }
        }
    }

    /// As the executor's threads do: a word with the others before stealing, then what the queue
    /// says.
    fn take(&mut self, now_us: u64, number: usize) {
        let worker = &mut self.workers[number];
        if worker.queue.is_idle()
            && worker.exchanged_us + micros(EXCHANGE_INTERVAL.as_secs_f64()) <= now_us
        {
            worker.exchanged_us = now_us;
            if worker.queue.own_share_finished() && !std::mem::replace(&mut worker.recorded, true) {
                self.finished.push(number);
                self.replayed.operations += 1;
            }
            return self.operate(now_us, number, Step::Exchanged);
        }
        self.take_next(now_us, number);
    }

    /// A pause where the queue has nothing, the end where others suffice.
    fn take_next(&mut self, now_us: u64, number: usize) {
        let worker = &mut self.workers[number];
        let Some(stage) = worker.queue.take() else {
            if worker.queue.unfinished() > number {
                let end_us = now_us + worker.pause_us;
                self.replayed.idle_s += worker.pause_us as f64 * 1e-6;
                worker.pause_us = (2 * worker.pause_us).min(micros(MAX_PAUSE.as_secs_f64()));
                self.then(end_us, number, Step::Resume);
            }
            return;
        };
        let next = if worker.queue.owns(stage) { Step::Lock(stage) } else { Step::LookedUp(stage) };
        self.operate(now_us, number, next);
    }

    fn look_up_inputs(&mut self, now_us: u64, number: usize, stage: usize) {
        let unknown = self.workers[number].queue.unknown_inputs(stage);
        let next =
            unknown.first().map_or(Step::Lock(stage), |&input| Step::LookedUpInput(stage, input));
        self.operate(now_us, number, next);
    }

    /// Reads an input that is not in memory, or computes.
    fn compute(&mut self, now_us: u64, number: usize, stage: usize) {
        let held = &self.workers[number].held;
        let absent = self.graph.inputs(stage).iter().find(|input| !held.contains(input));
        if let Some(&input) = absent {
            let read_us = self.read(now_us, self.costs.bytes[input]);
            self.workers[number].hold(input);
            return self.then(read_us, number, Step::Locked(stage));
        }
        self.then(now_us + micros(self.costs.stage_s[stage]), number, Step::Computed(stage));
    }

    /// The end of a transfer: everyone shares one line.
    fn line(&mut self, now_us: u64, bytes: f64) -> u64 {
        self.line_free_us =
            self.line_free_us.max(now_us) + micros(bytes / self.assumed.store_bytes_s);
        self.replayed.bytes += bytes;
        self.line_free_us
    }

    /// Reads an entry; when the worker has it.
    fn read(&mut self, now_us: u64, bytes: f64) -> u64 {
        let end_us = self.line(now_us, bytes) + micros(self.assumed.store_operation_s);
        self.replayed.operations += 1;
        self.replayed.store_s += (end_us - now_us) as f64 * 1e-6;
        end_us
    }

    /// One operation of the store that the worker waits for.
    fn operate(&mut self, now_us: u64, number: usize, next: Step) {
        self.replayed.store_s += self.assumed.store_operation_s;
        self.background(now_us, number, 1, next);
    }

    /// Operations of the store that it does not wait for.
    fn background(&mut self, now_us: u64, number: usize, count: u64, next: Step) {
        self.replayed.operations += count;
        self.then(now_us + count * micros(self.assumed.store_operation_s), number, next);
    }

    fn then(&mut self, at_us: u64, number: usize, step: Step) {
        self.events.push(Reverse((at_us, number, step)));
    }
}
