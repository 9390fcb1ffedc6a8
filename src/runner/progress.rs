//! What a run tells while it runs: a bar, lines of JSON, or nothing. Always on stderr.

use super::timing::Timing;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
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
pub struct Told<'a> {
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
    left: Mutex<Left>,
}

#[derive(Default)]
struct Left {
    total: usize,
    done: usize,
    failed: usize,
}

impl Progress {
    /// A teller in this style; the bar appears when there is something to do.
    pub fn new(style: Style) -> Progress {
        let visible = style == Style::Human && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        Progress { style, bar: ProgressBar::with_draw_target(Some(0), target), left: Mutex::default() }
    }

    /// The work is known: `compute` stages of `cost_ms` together, and `cached` that need nothing.
    pub fn planned(&self, compute: usize, cached: usize, cost_ms: u64) {
        if let Ok(mut left) = self.left.lock() {
            left.total = compute;
        }
        self.event("planned", json!({ "compute": compute, "cached": cached }));
        self.bar.set_length(cost_ms);
        let template = "{bar:32} {percent:>3} %  {msg}  left: {eta}";
        self.bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
        self.bar.enable_steady_tick(std::time::Duration::from_millis(250));
    }

    /// A stage begins.
    pub fn started(&self, told: Told) {
        self.event("started", json!({ "stage": told.stage, "label": told.label, "key": told.key }));
    }

    /// A stage ended, with its failure if it failed.
    pub fn finished(&self, told: Told, timing: Timing, failure: Option<&str>) {
        let state = json!({ "stage": told.stage, "label": told.label, "key": told.key, "wall_s": timing.wall_s,
                            "cpu_s": timing.cpu_s, "failure": failure });
        self.event("finished", state);
        if let Some(failure) = failure {
            self.notice(&format!("{} {} failed: {failure}", told.stage, told.label));
        }
        let Ok(mut left) = self.left.lock() else { return };
        left.done += 1;
        left.failed += usize::from(failure.is_some());
        let failed = if left.failed > 0 { format!(", {} failed", left.failed) } else { String::new() };
        self.bar.set_message(format!("{} of {} stages{failed}, last {}", left.done, left.total, told.stage));
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
