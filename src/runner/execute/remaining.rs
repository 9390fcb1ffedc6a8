//! How long the rest of a run takes: from what the stages of each kind have taken, in this run and
//! in those before.

use std::collections::BTreeMap;
use std::time::Instant;

/// Weight of the mean of earlier runs, in stages of this run.
const EARLIER_RUNS_WEIGHT: f64 = 3.0;
/// Share of a new estimate in what is shown, a second (exponential smoothing): the rest is the last
/// one, less the time since.
const SMOOTHING_SHARE: f64 = 0.05;

/// Share of a stage from which on its own pace counts.
const MIN_SHARE: f64 = 0.05;

/// What is left of a run.
#[derive(Debug)]
pub(crate) struct RemainingTime {
    kinds: BTreeMap<String, KindOfStage>,
    /// The stages at work, by their number.
    running: BTreeMap<usize, RunningStage>,
    threads: f64,
    /// All stages of the run, and those that are done.
    stages: usize,
    done: usize,
    /// The last estimate, seconds, and when it was made.
    last_estimate: Option<(f64, Instant)>,
    began: Instant,
}

/// The stages of one kind. Costs are those that were expected, seconds.
#[derive(Debug, Default)]
struct KindOfStage {
    /// Stages that have not begun.
    waiting_cost_s: f64,
    /// Stages that were computed in this run, and their seconds.
    done_cost_s: f64,
    done_s: f64,
    /// Seconds over cost in runs before, and the mean cost of a stage of this run.
    usual: Option<f64>,
    mean_cost_s: f64,
}

/// A stage at work.
#[derive(Debug)]
struct RunningStage {
    kind: String,
    cost_s: f64,
    since: Instant,
    /// Share of it that is done, where it says so.
    share: f64,
}

impl RemainingTime {
    /// Nothing to do.
    pub(crate) fn none() -> RemainingTime {
        RemainingTime {
            kinds: BTreeMap::new(),
            running: BTreeMap::new(),
            threads: 1.0,
            stages: 0,
            done: 0,
            last_estimate: None,
            began: Instant::now(),
        }
    }

    /// The stages to compute, each with its kind and expected cost in milliseconds, on so many
    /// threads. `usual`: seconds over cost of a kind in runs before.
    pub(crate) fn new<'a>(
        stages: impl Iterator<Item = (&'a str, u64)>,
        threads: usize,
        usual: &dyn Fn(&str) -> Option<f64>,
    ) -> RemainingTime {
        let mut kinds: BTreeMap<String, (KindOfStage, usize)> = BTreeMap::new();
        for (kind, cost_ms) in stages {
            let (of_kind, count) = kinds.entry(kind.to_owned()).or_insert_with(|| {
                (KindOfStage { usual: usual(kind), ..KindOfStage::default() }, 0)
            });
            of_kind.waiting_cost_s += seconds(cost_ms);
            *count += 1;
        }
        let stages = kinds.values().map(|(_, count)| count).sum();
        let with_mean = |(kind, (of_kind, count)): (String, (KindOfStage, usize))| {
            (kind, KindOfStage { mean_cost_s: of_kind.waiting_cost_s / count as f64, ..of_kind })
        };
        let kinds = kinds.into_iter().map(with_mean).collect();
        RemainingTime { kinds, stages, threads: threads.max(1) as f64, ..RemainingTime::none() }
    }

    /// Stage `number` begins.
    pub(crate) fn started(&mut self, number: usize, kind: &str, cost_ms: u64) {
        self.started_at(number, kind, cost_ms, Instant::now());
    }

    fn started_at(&mut self, number: usize, kind: &str, cost_ms: u64, since: Instant) {
        let cost_s = seconds(cost_ms);
        if let Some(kind) = self.kinds.get_mut(kind) {
            kind.waiting_cost_s = (kind.waiting_cost_s - cost_s).max(0.0);
        }
        let stage = RunningStage { kind: kind.to_owned(), cost_s, since, share: 0.0 };
        self.running.insert(number, stage);
    }

    /// Stage `number` says which share of it is done.
    pub(crate) fn advanced(&mut self, number: usize, share: f64) {
        if let Some(stage) = self.running.get_mut(&number) {
            stage.share = share;
        }
    }

    /// Stage `number` ended after so many seconds; 0 where somebody else had computed it.
    pub(crate) fn finished(&mut self, number: usize, wall_s: f64) {
        self.done += 1;
        let Some(stage) = self.running.remove(&number) else { return };
        let Some(kind) = self.kinds.get_mut(&stage.kind) else { return };
        if wall_s > 0.0 {
            kind.done_cost_s += stage.cost_s;
            kind.done_s += wall_s;
        }
    }

    /// The estimate at `now`, smoothed, seconds; `None` while too little is known.
    pub(crate) fn remaining_s(&mut self, now: Instant) -> Option<f64> {
        let Some(estimate_s) = self.estimate_s(now) else {
            self.last_estimate = None;
            return None;
        };
        let shown_s = match self.last_estimate {
            None => estimate_s,
            Some((last_s, when)) => {
                let expected_s = (last_s - (now - when).as_secs_f64()).max(0.0);
                // Several looks within a second move it no faster than one.
                let share = SMOOTHING_SHARE * (now - when).as_secs_f64().min(1.0);
                expected_s + share * (estimate_s - expected_s)
            }
        };
        self.last_estimate = Some((shown_s, now));
        Some(shown_s)
    }

    /// Share of the work that is done, by time. However long the first stages take, half of the way
    /// is that of the number of stages.
    pub(crate) fn share_done(&mut self, now: Instant) -> f64 {
        let passed_s = (now - self.began).as_secs_f64();
        let by_time = self
            .remaining_s(now)
            .map_or(0.0, |remaining_s| passed_s / (passed_s + remaining_s).max(1e-9));
        let by_number = self.done as f64 / self.stages.max(1) as f64;
        by_time.min(0.5 + 0.5 * by_number)
    }

    fn estimate_s(&self, now: Instant) -> Option<f64> {
        let known = self.kinds.values().filter_map(|kind| Some((kind.ratio()?, kind.mean_cost_s)));
        let (seconds_s, costs_s) = known
            .fold((0.0, 0.0), |(seconds_s, costs_s), (ratio, cost_s)| {
                (seconds_s + ratio * cost_s, costs_s + cost_s)
            });
        // Kinds of which nothing is known are as much slower as the others.
        let scale = if costs_s > 0.0 { seconds_s / costs_s } else { 1.0 };
        let (mut known_s, mut all_s, mut remaining_s, mut longest_s) = (0.0, 0.0, 0.0, 0.0_f64);
        for (name, kind) in &self.kinds {
            let running = || self.running.values().filter(|stage| stage.kind == *name);
            // A stage that outlasts the others of its kind says something of them, too.
            let slowest = running()
                .filter(|stage| stage.cost_s > 0.0)
                .map(|stage| stage.passed_s(now) / stage.cost_s)
                .fold(0.0, f64::max);
            let ratio = kind.ratio().unwrap_or(scale).max(slowest);
            let at_work_s: f64 = running().map(|stage| stage.cost_s).sum();
            let work_s = ratio * (kind.waiting_cost_s + at_work_s);
            all_s += work_s;
            known_s += if kind.ratio().is_some() { work_s } else { 0.0 };
            remaining_s += ratio * kind.waiting_cost_s;
            for stage in running() {
                let stage_s = stage.remaining_s(now, ratio);
                remaining_s += stage_s;
                longest_s = longest_s.max(stage_s);
            }
        }
        // Half of the work must be of kinds whose times are known.
        (known_s >= 0.5 * all_s).then(|| (remaining_s / self.threads).max(longest_s))
    }
}

impl KindOfStage {
    /// Seconds over cost, of this run and those before; `None` where neither knows.
    fn ratio(&self) -> Option<f64> {
        let weight_s = self.usual.map_or(0.0, |_| EARLIER_RUNS_WEIGHT * self.mean_cost_s);
        let cost_s = weight_s + self.done_cost_s;
        (cost_s > 0.0).then(|| (weight_s * self.usual.unwrap_or(0.0) + self.done_s) / cost_s)
    }
}

impl RunningStage {
    fn passed_s(&self, now: Instant) -> f64 {
        now.saturating_duration_since(self.since).as_secs_f64()
    }

    /// What is left of it, seconds: by its own share once that means something, else by its cost.
    fn remaining_s(&self, now: Instant, ratio: f64) -> f64 {
        let passed_s = self.passed_s(now);
        if self.share >= MIN_SHARE {
            passed_s * (1.0 - self.share) / self.share
        } else {
            (ratio * self.cost_s - passed_s).max(0.0)
        }
    }
}

fn seconds(cost_ms: u64) -> f64 {
    cost_ms as f64 * 1e-3
}

/// A time as a person would say it: `a few seconds`, `about 40 s`, `about 18 min`, `about 2 h`.
pub(crate) fn about(remaining_s: f64) -> String {
    let rounded = |unit_s: f64, step: f64| (remaining_s / unit_s / step).round().max(1.0) * step;
    match remaining_s {
        s if s < 5.0 => "a few seconds".to_owned(),
        s if s < 90.0 => format!("about {} s", rounded(1.0, 10.0)),
        s if s < 5400.0 => format!("about {} min", rounded(60.0, 1.0)),
        s if s < 36_000.0 => format!("about {} h", rounded(3600.0, 0.5)),
        s if s < 172_800.0 => format!("about {} h", rounded(3600.0, 1.0)),
        _ => format!("about {} days", rounded(86_400.0, 1.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// Many short stages, then a few long ones whose expected costs mislead by a factor of ten.
    fn run(usual: &dyn Fn(&str) -> Option<f64>) -> Vec<(f64, Option<f64>)> {
        let stages = (0..40).map(|_| ("short", 1000)).chain((0..10).map(|_| ("long", 1000)));
        let mut remaining = RemainingTime::new(stages, 1, usual);
        let mut now = remaining.began;
        let mut estimates = Vec::new();
        for (kind, count, wall_s) in [("short", 40, 1.0), ("long", 10, 20.0)] {
            for number in 0..count {
                remaining.started_at(number, kind, 1000, now);
                for _ in 0..(wall_s as u64) {
                    now += Duration::from_secs(1);
                    let passed_s = (now - remaining.began).as_secs_f64();
                    estimates.push((240.0 - passed_s, remaining.remaining_s(now)));
                }
                remaining.finished(number, wall_s);
            }
        }
        estimates
    }

    #[test]
    fn what_a_small_run_took_says_what_a_large_one_takes() {
        // Training took 0.4 times its cost in a run of seconds, trials 2 times theirs.
        let usual = |kind: &str| Some(if kind == "train" { 0.4 } else { 2.0 });
        let stages = [("train", 300_000), ("reach", 1000), ("reach", 1000)];
        let mut remaining = RemainingTime::new(stages.into_iter(), 1, &usual);
        let began = remaining.began;
        assert_eq!(remaining.remaining_s(began).map(f64::round), Some(124.0));
        // A third of the training after 20 s: 40 s for what is left of it.
        remaining.started_at(0, "train", 300_000, began);
        remaining.advanced(0, 1.0 / 3.0);
        remaining.last_estimate = None;
        let now = began + Duration::from_secs(20);
        assert_eq!(remaining.remaining_s(now).map(f64::round), Some(44.0));
    }

    #[test]
    fn the_bar_is_never_full_while_most_stages_wait() {
        let stages = std::iter::once(("slow", 1)).chain((0..108).map(|_| ("fast", 1)));
        let mut remaining = RemainingTime::new(stages, 1, &|_| Some(0.001));
        let began = remaining.began;
        remaining.started_at(0, "slow", 1, began);
        remaining.finished(0, 40.0);
        let share = remaining.share_done(began + Duration::from_secs(40));
        assert!(share < 0.52, "{share}");
    }

    #[test]
    fn what_the_store_knows_makes_the_estimate_right_from_the_start() {
        let usual = |kind: &str| Some(if kind == "short" { 1.1 } else { 19.0 });
        for (truth_s, estimate_s) in run(&usual) {
            assert!(
                (estimate_s.unwrap() - truth_s).abs() < 0.12 * truth_s + 4.0,
                "{estimate_s:?} for {truth_s}"
            );
        }
    }

    #[test]
    fn without_knowledge_the_estimate_never_jumps() {
        let estimates = run(&|_| None);
        let mut last: Option<f64> = None;
        for (_, estimate_s) in &estimates {
            if let (Some(last_s), Some(estimate_s)) = (last, *estimate_s) {
                assert!(
                    (estimate_s - last_s).abs() < 0.1 * last_s.max(estimate_s) + 2.0,
                    "{last_s} then {estimate_s}"
                );
            }
            last = *estimate_s;
        }
        let (truth_s, at_last_s) = estimates[estimates.len() - 30];
        assert!(
            (at_last_s.unwrap() - truth_s).abs() < 0.3 * truth_s,
            "{at_last_s:?} for {truth_s}"
        );
    }

    #[test]
    fn times_are_round() {
        let all = [3.0, 12.0, 44.0, 1080.0, 9000.0, 400_000.0].map(about);
        assert_eq!(
            all,
            [
                "a few seconds",
                "about 10 s",
                "about 40 s",
                "about 18 min",
                "about 2.5 h",
                "about 5 days"
            ]
        );
    }
}
