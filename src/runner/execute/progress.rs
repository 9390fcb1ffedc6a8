//! What a run tells while it runs: a bar, lines of JSON, or nothing. Always on stderr.

use super::remaining::{RemainingTime, about};
use crate::runner::graph::timing::Timing;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// How to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A bar when stderr is a terminal, notices otherwise.
    Human,
    /// Notices only.
    Quiet,
    /// One JSON object a line.
    Json,
}

/// One stage, as it is told of.
#[derive(Clone, Copy, Debug)]
pub struct StageEvent<'a> {
    /// Its number in the graph.
    pub number: usize,
    /// Kind of stage.
    pub stage: &'a str,
    /// Which of them.
    pub label: &'a str,
    /// Its key, shortened.
    pub key: &'a str,
    /// Rough cost, milliseconds.
    pub cost_ms: u64,
}

/// The teller.
pub struct Progress {
    style: Style,
    bar: ProgressBar,
    counts: Mutex<StageCounts>,
    remaining: Arc<Mutex<RemainingTime>>,
}

/// Parts of the length of the bar.
const BAR_PARTS: u64 = 1000;

#[derive(Default)]
struct StageCounts {
    total: usize,
    done: usize,
    failed: usize,
    /// Done and all of each kind.
    kinds: BTreeMap<String, [usize; 2]>,
}

impl StageCounts {
    /// How far everything and the kind of the last stage are.
    fn words(&self, stage: &str) -> String {
        let failed =
            if self.failed > 0 { format!(", {} failed", self.failed) } else { String::new() };
        let [done, all] = self.kinds.get(stage).copied().unwrap_or_default();
        format!("{} of {} stages{failed}, {stage} {done}/{all}", self.done, self.total)
    }
}

impl Progress {
    /// A teller in this style; the bar appears when there is something to do.
    pub fn new(style: Style) -> Progress {
        let visible = style == Style::Human && std::io::stderr().is_terminal();
        let target =
            if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let remaining = Arc::new(Mutex::new(RemainingTime::none()));
        Progress { style, bar, counts: Mutex::default(), remaining }
    }

    /// Whether only notes are told.
    pub fn is_quiet(&self) -> bool {
        self.style == Style::Quiet
    }

    /// The work is known: stages to compute on so many threads, each with its kind and rough cost
    /// in milliseconds, and `cached` that need nothing. `usual`: what a stage of a kind took in runs
    /// before, seconds over its cost.
    pub fn planned<'a>(
        &self,
        compute: impl Iterator<Item = (&'a str, u64)> + Clone,
        cached: usize,
        threads: usize,
        usual: &dyn Fn(&str) -> Option<f64>,
    ) {
        let mut planned = StageCounts::default();
        for (kind, _) in compute.clone() {
            planned.kinds.entry(kind.to_owned()).or_default()[1] += 1;
            planned.total += 1;
        }
        if let Ok(mut remaining) = self.remaining.lock() {
            *remaining = RemainingTime::new(compute, threads, usual);
        }
        self.event("planned", json!({ "compute": planned.total, "cached": cached }));
        if let Ok(mut counts) = self.counts.lock() {
            *counts = planned;
        }
        self.bar.set_length(BAR_PARTS);
        self.bar.reset();
        let remaining = Arc::clone(&self.remaining);
        let write_remaining = move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
            let remaining_s = remaining
                .lock()
                .ok()
                .and_then(|mut remaining| remaining.remaining_s(Instant::now()));
            let _ = match remaining_s {
                Some(remaining_s) => write!(out, "{} left", about(remaining_s)),
                None => write!(out, "estimating the time left"),
            };
        };
        let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}  {remaining}");
        self.bar.set_style(
            style
                .unwrap_or_else(|_| ProgressStyle::default_bar())
                .with_key("remaining", write_remaining),
        );
        self.bar.enable_steady_tick(Duration::from_millis(250));
    }

    /// A stage begins.
    pub fn started(&self, event: StageEvent) {
        if let Ok(mut remaining) = self.remaining.lock() {
            remaining.started(event.number, event.stage, event.cost_ms);
        }
        self.event(
            "started",
            json!({ "stage": event.stage, "label": event.label, "key": event.key }),
        );
    }

    /// A stage ended, with its failure if it failed.
    pub fn finished(&self, event: StageEvent, timing: Timing, failure: Option<&str>) {
        let state = json!({ "stage": event.stage, "label": event.label, "key": event.key, "wall_s": timing.wall_s,
                            "cpu_s": timing.cpu_s, "failure": failure });
        self.event("finished", state);
        if let Some(failure) = failure {
            self.notice(&format!("{} {} failed: {failure}", event.stage, event.label));
        }
        let Ok(mut counts) = self.counts.lock() else { return };
        counts.done += 1;
        counts.failed += usize::from(failure.is_some());
        if let Some([done, _]) = counts.kinds.get_mut(event.stage) {
            *done += 1;
        }
        self.bar.set_message(counts.words(event.stage));
        if let Ok(mut remaining) = self.remaining.lock() {
            remaining.finished(event.number, timing.wall_s);
        }
        self.of_stage().move_bar();
    }

    /// What a stage at work reports to.
    pub(crate) fn of_stage(&self) -> StageProgress {
        StageProgress { bar: self.bar.clone(), remaining: Arc::clone(&self.remaining) }
    }

    /// Something that a person should know.
    pub fn notice(&self, text: &str) {
        match self.style {
            Style::Json => self.event("notice", json!({ "text": text })),
            Style::Human | Style::Quiet => self.bar.suspend(|| eprintln!("note: {text}")),
        }
    }

    /// A line for a person that is no warning; quiet runs do without.
    pub fn say(&self, text: &str) {
        match self.style {
            Style::Json => self.event("summary", json!({ "text": text })),
            Style::Human => self.bar.suspend(|| eprintln!("{text}")),
            Style::Quiet => {}
        }
    }

    /// A step of a command that has no stages of its own begins.
    pub fn step(&self, text: &str) {
        self.event("step", json!({ "text": text }));
        if self.bar.position() == 0 && self.bar.length() == Some(0) {
            let style = ProgressStyle::with_template("{spinner} {msg}  {elapsed}");
            self.bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
            self.bar.enable_steady_tick(Duration::from_millis(250));
        }
        self.bar.set_message(text.to_owned());
    }

    /// How many stages are done, and how many there are to compute.
    pub fn counts(&self) -> (usize, usize) {
        self.counts.lock().map_or((0, 0), |counts| (counts.done, counts.total))
    }

    /// Everything is done.
    pub fn done(&self) {
        self.bar.finish_and_clear();
    }

    fn event(&self, name: &str, mut fields: serde_json::Value) {
        if self.style == Style::Json {
            fields["event"] = name.into();
            eprintln!("{fields}");
        }
    }
}

/// The bar and the time that is left, for a stage at work.
#[derive(Clone)]
pub(crate) struct StageProgress {
    bar: ProgressBar,
    remaining: Arc<Mutex<RemainingTime>>,
}

impl StageProgress {
    /// This share of stage `number` is done.
    pub(crate) fn advanced(&self, number: usize, share: f64) {
        if self.bar.is_hidden() {
            return;
        }
        if let Ok(mut remaining) = self.remaining.lock() {
            remaining.advanced(number, share);
        }
        self.move_bar();
    }

    /// Moves the bar on, never back.
    fn move_bar(&self) {
        let Ok(mut remaining) = self.remaining.lock() else { return };
        let parts = (remaining.share_done(Instant::now()) * BAR_PARTS as f64) as u64;
        self.bar.set_position(self.bar.position().max(parts).min(BAR_PARTS));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_reads_how_far_it_is() {
        let kinds = BTreeMap::from([("reach".to_owned(), [3, 8]), ("train".to_owned(), [2, 2])]);
        let mut counts = StageCounts { total: 10, done: 5, failed: 0, kinds };
        assert_eq!(counts.words("reach"), "5 of 10 stages, reach 3/8");
        counts.failed = 1;
        assert_eq!(counts.words("train"), "5 of 10 stages, 1 failed, train 2/2");
    }
}
