//! The order in which a worker takes the stages of a run that several workers share.
//!
//! The missing stages are cut into one share per worker: neighbours in the graph, which need each
//! other's results, of about equal estimated cost. A worker first takes ready stages of its own
//! share and those that its share waits for, the stage with the longest chain of work behind it
//! first (critical path: R. L. Graham, *Bounds on multiprocessing timing anomalies*, SIAM J. Appl.
//! Math. 17, 1969). Without any, it steals from other shares, which it visits in a random order of
//! its own, so that idle workers spread (R. D. Blumofe, C. E. Leiserson, *Scheduling multithreaded
//! computations by work stealing*, J. ACM 46, 1999): it tries stages of a share in random order
//! until a few in a row turn out to be stored.

use super::plan::Need;
use crate::runner::graph::Graph;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// Stages of a share that a thief tries in vain, one after the other, before it goes to the next
/// share.
const MAX_MISSES_PER_SHARE: usize = 3;

/// The missing stages of a run and how workers divide them.
pub struct WorkPlan {
    /// Stages of each share, in the order of the graph.
    shares: Vec<Vec<usize>>,
    /// Share that each missing stage belongs to.
    share_of: Vec<usize>,
    /// Estimated cost of the longest chain that starts with each stage, milliseconds.
    priority_ms: Vec<u64>,
    /// Missing stages that read each stage, and missing stages that each reads.
    dependents: Vec<Vec<usize>>,
    inputs: Vec<Vec<usize>>,
}

impl WorkPlan {
    /// Divides the stages that must be computed among `workers` workers.
    pub fn new(graph: &Graph, needs: &[Need], workers: usize) -> WorkPlan {
        let count = graph.len();
        let is_missing = |stage: usize| needs[stage] == Need::Compute;
        let cost = |stage: usize| u128::from(graph.cost_ms(stage).max(1));
        let mut plan = WorkPlan {
            shares: vec![Vec::new(); workers],
            share_of: vec![0; count],
            priority_ms: vec![0; count],
            dependents: vec![Vec::new(); count],
            inputs: vec![Vec::new(); count],
        };
        // From the last stage to the first, so that the chains behind a stage are known when its
        // turn comes.
        let mut total_cost = 0;
        for stage in (0..count).rev().filter(|&stage| is_missing(stage)) {
            total_cost += cost(stage);
            plan.priority_ms[stage] += graph.cost_ms(stage);
            for &input in graph.inputs(stage).iter().filter(|&&input| is_missing(input)) {
                plan.inputs[stage].push(input);
                plan.dependents[input].push(stage);
                plan.priority_ms[input] = plan.priority_ms[input].max(plan.priority_ms[stage]);
            }
        }
        let mut cost_before = 0;
        for stage in (0..count).filter(|&stage| is_missing(stage)) {
            let share = (cost_before * workers as u128 / total_cost) as usize;
            plan.share_of[stage] = share;
            plan.shares[share].push(stage);
            cost_before += cost(stage);
        }
        plan
    }

    /// The missing stages, in the order of the graph.
    pub fn missing(&self) -> impl Iterator<Item = usize> + '_ {
        self.shares.iter().flatten().copied()
    }
}

/// What a worker knows of a missing stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StageState {
    Unknown,
    /// Taken, and neither finished nor postponed yet; or it waits until its inputs are known to be
    /// stored.
    Taken,
    /// Another worker computes it.
    Postponed,
    /// Stored or failed.
    Finished,
}

/// The stages that one worker can take, best first.
pub struct StageQueue<'a> {
    plan: &'a WorkPlan,
    worker: usize,
    state: Vec<StageState>,
    /// Missing inputs of each stage that this worker does not know to be finished.
    unfinished_inputs: Vec<usize>,
    /// Stages of other shares that this worker's share waits for.
    needed: Vec<bool>,
    /// Whether of the worker's own share, priority and number, which decide in this order.
    ready: BinaryHeap<(bool, u64, Reverse<usize>)>,
    /// Stages that another worker computes, the longest postponed first.
    postponed: VecDeque<usize>,
    /// Shares to steal from, the next one last, and stages of the current one to try.
    victims: Vec<usize>,
    candidates: Vec<usize>,
    misses: usize,
    unfinished: usize,
}

impl<'a> StageQueue<'a> {
    /// The queue of worker number `worker`, from 0.
    pub fn new(plan: &'a WorkPlan, worker: usize) -> StageQueue<'a> {
        let count = plan.share_of.len();
        let mut queue = StageQueue {
            plan,
            worker,
            state: vec![StageState::Unknown; count],
            unfinished_inputs: plan.inputs.iter().map(Vec::len).collect(),
            needed: vec![false; count],
            ready: BinaryHeap::new(),
            postponed: VecDeque::new(),
            victims: Vec::new(),
            candidates: Vec::new(),
            misses: 0,
            unfinished: plan.shares.iter().map(Vec::len).sum(),
        };
        let mut needed = plan.shares[worker].clone();
        while let Some(stage) = needed.pop() {
            if !std::mem::replace(&mut queue.needed[stage], true) {
                needed.extend(&plan.inputs[stage]);
                if queue.unfinished_inputs[stage] == 0 {
                    queue.push(stage);
                }
            }
        }
        queue.visit_others();
        queue
    }

    /// Takes the best ready stage, or one of another share that may be ready; `None` where this
    /// worker knows of none.
    pub fn take(&mut self) -> Option<usize> {
        loop {
            let stage = match self.ready.pop() {
                Some((_, _, Reverse(stage))) => stage,
                None => self.steal()?,
            };
            if self.state[stage] == StageState::Unknown {
                self.state[stage] = StageState::Taken;
                return Some(stage);
            }
        }
    }

    /// The next stage of another share to try.
    fn steal(&mut self) -> Option<usize> {
        loop {
            if self.misses < MAX_MISSES_PER_SHARE
                && let Some(stage) = self.candidates.pop()
            {
                self.misses += 1;
                return Some(stage);
            }
            let victim = self.victims.pop()?;
            self.misses = 0;
            self.candidates = self.plan.shares[victim].clone();
            self.candidates.retain(|&stage| self.state[stage] == StageState::Unknown);
            let worker = self.worker;
            self.candidates.sort_by_cached_key(|&stage| scrambled(worker, stage));
        }
    }

    /// Visits the other shares from now on, once each.
    fn visit_others(&mut self) {
        let (shares, worker) = (&self.plan.shares, self.worker);
        self.victims = (0..shares.len())
            .filter(|&share| share != worker && !shares[share].is_empty())
            .collect();
        self.victims.sort_by_cached_key(|&share| scrambled(worker, share));
    }

    /// Inputs of a taken stage that this worker does not know to be stored; none of a stage of its
    /// own share.
    pub fn unknown_inputs(&self, stage: usize) -> Vec<usize> {
        let unknown = |input: &usize| self.state[*input] != StageState::Finished;
        self.plan.inputs[stage].iter().copied().filter(unknown).collect()
    }

    /// This worker has computed a taken stage, or it has failed: dependents may have become ready.
    pub fn mark_computed(&mut self, stage: usize) {
        self.misses = 0;
        self.finish(stage, true);
    }

    /// A stage is found stored, and so is all that it was computed from.
    pub fn mark_stored(&mut self, stage: usize) {
        self.finish(stage, false);
    }

    /// The worker of a share has seen all its stages finished.
    pub fn mark_share_stored(&mut self, share: usize) {
        self.plan.shares[share].iter().for_each(|&stage| self.finish(stage, false));
        self.victims.retain(|&victim| victim != share);
    }

    fn finish(&mut self, stage: usize, computed: bool) {
        if std::mem::replace(&mut self.state[stage], StageState::Finished) == StageState::Finished {
            return;
        }
        self.unfinished -= 1;
        let plan = self.plan;
        for &next in &plan.dependents[stage] {
            self.unfinished_inputs[next] -= 1;
            // Stages of other shares are probably stored, too, unless this worker computed their
            // input or asked for them.
            let waits_for_inputs = self.state[next] == StageState::Taken;
            if self.unfinished_inputs[next] == 0
                && (computed || waits_for_inputs || self.needed[next])
            {
                self.push(next);
            }
        }
        plan.inputs[stage].iter().for_each(|&input| self.finish(input, false));
    }

    /// Another worker computes a taken stage: it waits until [`StageQueue::resume`].
    pub fn postpone(&mut self, stage: usize) {
        self.state[stage] = StageState::Postponed;
        self.postponed.push_back(stage);
    }

    /// Inputs of a taken stage are missing: they are taken next, the stage when all are stored.
    pub fn wait_for_inputs(&mut self, stage: usize) {
        self.misses = 0;
        for input in self.unknown_inputs(stage) {
            if self.state[input] == StageState::Unknown {
                self.push(input);
            }
        }
    }

    /// Makes at most `max_count` of the postponed stages ready again and visits the other shares
    /// again; how many.
    pub fn resume(&mut self, max_count: usize) -> usize {
        let resumed: Vec<usize> =
            self.postponed.drain(..max_count.min(self.postponed.len())).collect();
        resumed.iter().for_each(|&stage| self.push(stage));
        self.visit_others();
        resumed.len()
    }

    /// Stages that this worker does not know to be finished.
    pub fn unfinished(&self) -> usize {
        self.unfinished
    }

    /// Whether a stage is of this worker's own share.
    pub fn owns(&self, stage: usize) -> bool {
        self.plan.share_of[stage] == self.worker
    }

    /// Whether no stage is known to be ready: the next one would be stolen.
    pub fn is_idle(&self) -> bool {
        self.ready.is_empty()
    }

    /// Whether this worker knows all stages of its own share to be finished.
    pub fn own_share_finished(&self) -> bool {
        self.plan.shares[self.worker].iter().all(|&stage| self.state[stage] == StageState::Finished)
    }

    fn push(&mut self, stage: usize) {
        if self.state[stage] != StageState::Finished {
            self.state[stage] = StageState::Unknown;
            self.ready.push((self.owns(stage), self.plan.priority_ms[stage], Reverse(stage)));
        }
    }
}

/// A number that looks random, the same for the same two numbers (SplitMix64: Steele et al., OOPSLA
/// 2014).
fn scrambled(worker: usize, number: usize) -> u64 {
    let mut bits = ((worker as u64) << 32 | number as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ bits >> 31
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runner::graph::stage::{Handle, Stage, StageKind};

    /// A graph of stages with these costs and inputs.
    fn graph(stages: &[(u64, &[usize])]) -> Graph {
        let mut graph = Graph::default();
        for (number, (cost_ms, inputs)) in stages.iter().enumerate() {
            let kind = StageKind {
                name: "test",
                module: "spinebench::runner::jobs::data::path",
                cost_ms: *cost_ms,
            };
            let inputs: Vec<Handle<u64>> = inputs.iter().map(|&input| Handle::new(input)).collect();
            let stage: Stage<usize, Vec<Handle<u64>>, u64> = Stage { kind, job: |_, _| Ok(1) };
            graph.stage(&stage, "", number, inputs).unwrap();
        }
        graph
    }

    /// Two seeds of four stages each; the last two of each need the first of all, too.
    const STAGES: [(u64, &[usize]); 8] = [
        (300, &[]),
        (100, &[0]),
        (100, &[1]),
        (100, &[0]),
        (400, &[]),
        (100, &[4, 0]),
        (50, &[5]),
        (50, &[4, 0]),
    ];

    /// Takes and computes stages until none is left to take.
    fn drain(queue: &mut StageQueue) -> Vec<usize> {
        std::iter::from_fn(|| queue.take().inspect(|&stage| queue.mark_computed(stage))).collect()
    }

    #[test]
    fn own_stages_come_first_then_what_they_need_then_those_of_others() {
        let graph = graph(&STAGES);
        let plan = WorkPlan::new(&graph, &[Need::Compute; 8], 2);
        assert_eq!(plan.shares, [[0, 1, 2, 3], [4, 5, 6, 7]]);
        let mut queue = StageQueue::new(&plan, 1);
        assert_eq!((queue.take(), queue.take(), queue.is_idle()), (Some(4), Some(0), true));
        queue.mark_computed(4);
        queue.postpone(0);
        assert_eq!((queue.resume(10), queue.take()), (1, Some(0)));
        queue.mark_stored(0);
        // The longest chain first: 5 with 6 behind it. Then what is left of the other share.
        assert_eq!([queue.take(), queue.take()], [Some(5), Some(7)]);
        assert!(!queue.own_share_finished());
        queue.mark_computed(7);
        queue.mark_computed(5);
        assert_eq!(queue.take(), Some(6));
        queue.mark_computed(6);
        assert!(queue.own_share_finished() && queue.unfinished() == 3);
        let stolen = queue.take().unwrap();
        assert!(stolen < 4 && !queue.owns(stolen));
    }

    #[test]
    fn a_stolen_stage_waits_for_its_missing_inputs_and_a_stored_one_tells_of_its_inputs() {
        let graph = graph(&STAGES);
        let plan = WorkPlan::new(&graph, &[Need::Compute; 8], 2);
        let mut queue = StageQueue::new(&plan, 0);
        assert_eq!(drain(&mut queue)[..4], [0, 1, 2, 3]);
        let mut thief = StageQueue::new(&plan, 0);
        (0..4).for_each(|stage| thief.mark_stored(stage));
        thief.state[6] = StageState::Taken;
        assert_eq!(thief.unknown_inputs(6), [5]);
        thief.wait_for_inputs(6);
        assert_eq!((thief.take(), thief.unknown_inputs(5)), (Some(5), vec![4]));
        thief.wait_for_inputs(5);
        assert_eq!(thief.take(), Some(4));
        thief.mark_computed(4);
        assert_eq!(thief.take(), Some(5));
        thief.mark_stored(5);
        assert_eq!(drain(&mut thief), [6, 7]);
        let mut other = StageQueue::new(&plan, 0);
        other.mark_stored(6);
        assert_eq!(other.unfinished(), 4, "6 was computed from 5, 4 and 0");
        other.mark_share_stored(0);
        assert_eq!((other.unfinished(), other.own_share_finished()), (1, true));
        assert_eq!((drain(&mut other), other.unfinished()), (vec![7], 0));
    }

    #[test]
    fn a_stolen_stage_asks_for_all_its_unknown_inputs() {
        let graph = graph(&[(100, &[]), (100, &[]), (100, &[0, 1]), (100, &[])]);
        let plan = WorkPlan::new(&graph, &[Need::Compute; 4], 4);
        let mut thief = StageQueue::new(&plan, 3);
        assert_eq!(thief.take(), Some(3));
        thief.state[2] = StageState::Taken;
        thief.wait_for_inputs(2);
        assert_eq!([thief.take(), thief.take()], [Some(0), Some(1)]);
        thief.mark_computed(0);
        thief.mark_stored(1);
        assert_eq!(thief.take(), Some(2));
    }

    #[test]
    fn workers_visit_each_others_shares_in_different_orders() {
        let stages: Vec<(u64, &[usize])> = vec![(100, &[]); 100];
        let graph = graph(&stages);
        let plan = WorkPlan::new(&graph, &[Need::Compute; 100], 100);
        let second = |worker: usize| {
            let mut queue = StageQueue::new(&plan, worker);
            assert_eq!(queue.take(), Some(worker), "the own share first");
            queue.take()
        };
        let seconds: std::collections::BTreeSet<Option<usize>> = (0..100).map(second).collect();
        assert!(seconds.len() > 50, "{} different second choices of 100 workers", seconds.len());
        assert_eq!(
            drain(&mut StageQueue::new(&plan, 7)).len(),
            100,
            "one worker reaches all stages"
        );
    }

    #[test]
    fn stored_stages_are_in_nobodys_share() {
        let graph = graph(&STAGES);
        let mut needs = [Need::Compute; 8];
        (needs[0], needs[4]) = (Need::Cached, Need::Cached);
        let plan = WorkPlan::new(&graph, &needs, 1);
        assert_eq!((&plan.shares, &plan.dependents[0]), (&vec![vec![1, 2, 3, 5, 6, 7]], &vec![]));
        assert_eq!(drain(&mut StageQueue::new(&plan, 0)), [1, 5, 2, 3, 6, 7]);
    }
}
