//! What a run tells while it runs: a bar, lines of JSON, or nothing. Always on stderr.

use super::timing::Timing;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::sync::Mutex;

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
    left: Mutex<StageCounts>,
}

#[derive(Default)]
struct StageCounts {
    total: usize,
    done: usize,
    failed: usize,
    /// Done and all of each kind.
    kinds: BTreeMap<String, [usize; 2]>,
}

impl StageCounts {
    /// How far everything and the kind of the last stage are, and how fast it goes.
    fn words(&self, stage: &str, elapsed_s: f64) -> String {
        let failed = if self.failed > 0 { format!(", {} failed", self.failed) } else { String::new() };
        let [done, all] = self.kinds.get(stage).copied().unwrap_or_default();
        #[allow(clippy::cast_precision_loss)] // counts for a person
        let per_min = 60.0 * self.done as f64 / elapsed_s.max(1e-3);
        format!("{} of {} stages{failed}, {per_min:.0}/min, {stage} {done}/{all}", self.done, self.total)
    }
}

impl Progress {
    /// A teller in this style; the bar appears when there is something to do.
    pub fn new(style: Style) -> Progress {
        let visible = style == Style::Human && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        Progress { style, bar: ProgressBar::with_draw_target(Some(0), target), left: Mutex::default() }
    }

    /// The work is known: stages to compute, each with its kind and rough cost in milliseconds, and `cached` that need
    /// nothing.
    pub fn planned<'a>(&self, compute: impl Iterator<Item = (&'a str, u64)>, cached: usize) {
        let mut left = StageCounts::default();
        let mut all_ms = 0;
        for (kind, cost_ms) in compute {
            left.kinds.entry(kind.to_owned()).or_default()[1] += 1;
            (left.total, all_ms) = (left.total + 1, all_ms + cost_ms);
        }
        self.event("planned", json!({ "compute": left.total, "cached": cached }));
        if let Ok(mut known) = self.left.lock() {
            *known = left;
        }
        self.bar.set_length(all_ms);
        self.bar.reset();
        let template = "{bar:32} {percent:>3} %  {msg}  left: {eta}";
        self.bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
        self.bar.enable_steady_tick(std::time::Duration::from_millis(250));
    }

    /// A stage begins.
    pub fn started(&self, told: StageEvent) {
        self.event("started", json!({ "stage": told.stage, "label": told.label, "key": told.key }));
    }

    /// A stage ended, with its failure if it failed.
    pub fn finished(&self, told: StageEvent, timing: Timing, failure: Option<&str>) {
        let state = json!({ "stage": told.stage, "label": told.label, "key": told.key, "wall_s": timing.wall_s,
                            "cpu_s": timing.cpu_s, "failure": failure });
        self.event("finished", state);
        if let Some(failure) = failure {
            self.notice(&format!("{} {} failed: {failure}", told.stage, told.label));
        }
        let Ok(mut left) = self.left.lock() else { return };
        left.done += 1;
        left.failed += usize::from(failure.is_some());
        if let Some([done, _]) = left.kinds.get_mut(told.stage) {
            *done += 1;
        }
        self.bar.set_message(left.words(told.stage, self.bar.elapsed().as_secs_f64()));
        self.bar.inc(told.cost_ms);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_reads_how_far_and_how_fast_it_goes() {
        let kinds = BTreeMap::from([("reach".to_owned(), [3, 8]), ("train".to_owned(), [2, 2])]);
        let mut left = StageCounts { total: 10, done: 5, failed: 0, kinds };
        assert_eq!(left.words("reach", 60.0), "5 of 10 stages, 5/min, reach 3/8");
        left.failed = 1;
        assert_eq!(left.words("train", 30.0), "5 of 10 stages, 1 failed, 10/min, train 2/2");
    }
}
