//! How long the rest of a run takes: from what the stages of each kind have taken, in this run and
//! in those before.

use std::collections::BTreeMap;
use std::time::Instant;

/// Weight of the mean of earlier runs, in stages of this run.
const EARLIER_RUNS_WEIGHT: f64 = 3.0;
/// Share of a new estimate in what is shown, a second (exponential smoothing): the rest is the last
/// one, less the time since.
const SMOOTHING_SHARE: f64 = 0.05;

/// What is left of a run.
#[derive(Debug)]
pub(crate) struct RemainingTime {
    kinds: BTreeMap<String, KindOfStage>,
    threads: f64,
    /// The last estimate, seconds, and when it was made.
    last_estimate: Option<(f64, Instant)>,
    began: Instant,
}

/// The stages of one kind.
#[derive(Debug, Default)]
struct KindOfStage {
    /// Stages that are not done, those at work among them.
    unfinished: usize,
    /// When the stages at work began.
    running_since: Vec<Instant>,
    /// Stages that were computed in this run, and their seconds.
    done: usize,
    done_s: f64,
    /// Mean in runs before, seconds.
    usual_s: Option<f64>,
    /// Rough cost, seconds.
    cost_s: f64,
}

impl RemainingTime {
    /// Nothing to do.
    pub(crate) fn none() -> RemainingTime {
        RemainingTime {
            kinds: BTreeMap::new(),
            threads: 1.0,
            last_estimate: None,
            began: Instant::now(),
        }
    }

    /// The stages to compute, each with its kind and rough cost in milliseconds, on so many
    /// threads. `usual_s`: what a stage of a kind took in runs before, seconds.
    pub(crate) fn new<'a>(
        stages: impl Iterator<Item = (&'a str, u64)>,
        threads: usize,
        usual_s: &dyn Fn(&str) -> Option<f64>,
    ) -> RemainingTime {
        let mut kinds: BTreeMap<String, KindOfStage> = BTreeMap::new();
        for (kind, cost_ms) in stages {
            let kind_of_stage = kinds.entry(kind.to_owned()).or_insert_with(|| KindOfStage {
                usual_s: usual_s(kind),
                cost_s: cost_ms as f64 * 1e-3,
                ..KindOfStage::default()
            });
            kind_of_stage.unfinished += 1;
        }
        RemainingTime { kinds, threads: threads.max(1) as f64, ..RemainingTime::none() }
    }

    /// A stage begins.
    pub(crate) fn started(&mut self, kind: &str) {
        if let Some(kind) = self.kinds.get_mut(kind) {
            kind.running_since.push(Instant::now());
        }
    }

    /// A stage ended after so many seconds; 0 where somebody else had computed it.
    pub(crate) fn finished(&mut self, kind: &str, wall_s: f64) {
        let Some(kind) = self.kinds.get_mut(kind) else { return };
        kind.unfinished = kind.unfinished.saturating_sub(1);
        if !kind.running_since.is_empty() {
            kind.running_since.remove(0);
        }
        if wall_s > 0.0 {
            kind.done += 1;
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

    /// Share of the work that is done, by time.
    pub(crate) fn share_done(&mut self, now: Instant) -> f64 {
        let passed_s = (now - self.began).as_secs_f64();
        self.remaining_s(now)
            .map_or(0.0, |remaining_s| passed_s / (passed_s + remaining_s).max(1e-9))
    }

    fn estimate_s(&self, now: Instant) -> Option<f64> {
        let (mut observed_s, mut cost_s) = (0.0, 0.0);
        for kind in self.kinds.values() {
            if let Some(mean_s) = kind.mean_s() {
                observed_s += mean_s;
                cost_s += kind.cost_s;
            }
        }
        let any = self.kinds.values().any(|kind| kind.mean_s().is_some());
        let scale = if any && cost_s > 0.0 { observed_s / cost_s } else { 1.0 };
        // A stage that outlasts the others of its kind says something of them, too.
        let mean_s = |kind: &KindOfStage| {
            let longest = kind
                .running_since
                .iter()
                .map(|&running_since| (now - running_since).as_secs_f64())
                .fold(0.0, f64::max);
            kind.mean_s().unwrap_or(scale * kind.cost_s).max(longest)
        };
        // Half of the work must be of kinds whose times are known.
        let work_s = |kind: &KindOfStage| kind.unfinished as f64 * mean_s(kind);
        let all_s: f64 = self.kinds.values().map(work_s).sum();
        let known_work_s: f64 =
            self.kinds.values().filter(|kind| kind.mean_s().is_some()).map(work_s).sum();
        if known_work_s < 0.5 * all_s {
            return None;
        }
        let remaining_s = |kind: &KindOfStage| {
            let at_work = kind
                .running_since
                .iter()
                .map(|&running_since| (now - running_since).as_secs_f64().min(mean_s(kind)));
            (work_s(kind) - at_work.sum::<f64>()).max(0.0)
        };
        Some(self.kinds.values().map(remaining_s).sum::<f64>() / self.threads)
    }
}

impl KindOfStage {
    /// What a stage takes, seconds, of this run and those before; `None` where neither knows.
    fn mean_s(&self) -> Option<f64> {
        let done = self.done as f64;
        match self.usual_s {
            Some(usual_s) => {
                Some((EARLIER_RUNS_WEIGHT * usual_s + self.done_s) / (EARLIER_RUNS_WEIGHT + done))
            }
            None => (self.done > 0).then(|| self.done_s / done),
        }
    }
}

/// A time as a person would say it: `about 40 s`, `about 18 min`, `about 2 h`.
pub(crate) fn about(remaining_s: f64) -> String {
    let rounded = |unit_s: f64, step: f64| (remaining_s / unit_s / step).round().max(1.0) * step;
    match remaining_s {
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

    /// Many short stages, then a few long ones whose rough costs mislead by a factor of ten.
    fn run(usual_s: &dyn Fn(&str) -> Option<f64>) -> Vec<(f64, Option<f64>)> {
        let stages = (0..40).map(|_| ("short", 1000)).chain((0..10).map(|_| ("long", 1000)));
        let mut remaining = RemainingTime::new(stages, 1, usual_s);
        let mut now = remaining.began;
        let mut estimates = Vec::new();
        for (kind, count, wall_s) in [("short", 40, 1.0), ("long", 10, 20.0)] {
            for _ in 0..count {
                remaining.kinds.get_mut(kind).unwrap().running_since.push(now);
                for _ in 0..(wall_s as u64) {
                    now += Duration::from_secs(1);
                    let passed_s = (now - remaining.began).as_secs_f64();
                    estimates.push((240.0 - passed_s, remaining.remaining_s(now)));
                }
                remaining.finished(kind, wall_s);
            }
        }
        estimates
    }

    #[test]
    fn what_the_store_knows_makes_the_estimate_right_from_the_start() {
        let usual_s = |kind: &str| Some(if kind == "short" { 1.1 } else { 19.0 });
        for (truth_s, estimate_s) in run(&usual_s) {
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
        let all = [3.0, 44.0, 1080.0, 9000.0, 400_000.0].map(about);
        assert_eq!(
            all,
            ["about 10 s", "about 40 s", "about 18 min", "about 2.5 h", "about 5 days"]
        );
    }
}
