//! Why the claims of a group have their verdicts: sentences with numbers of the published tables.

use maud::{Markup, html};
use std::path::Path;

use super::OverviewFacts;
use crate::data::DataError;
use crate::math::summary::mean;
use crate::report::paper::claim_lines::ClaimLine;
use crate::report::published_rows;
use crate::report::style::{ANY_TRAINING, policy_label, training_label};
use crate::rows::experiment::{ReachSummaryRow, TrackSummaryRow};

/// The controllers of the paper.
const PAPER_POLICIES: [&str; 4] = ["a", "b", "c", "pi_real"];

/// The tables behind the reasons.
pub(super) struct Reasons {
    table1: Vec<ReachSummaryRow>,
    tracks: Vec<TrackSummaryRow>,
    switch_threshold_m: Option<f64>,
}

impl Reasons {
    /// # Errors
    /// [`DataError`] for a table that cannot be read.
    pub(super) fn read(results: &Path, facts: &OverviewFacts) -> Result<Reasons, DataError> {
        Ok(Reasons {
            table1: published_rows(&results.join("table1"))?,
            tracks: published_rows(&results.join("fig8"))?,
            switch_threshold_m: facts.switch_threshold_m,
        })
    }

    /// The reason of the group with this index in the list of groups.
    pub(super) fn of_group(&self, index: usize) -> Markup {
        match index {
            0 => html! {
                "Gravity acts along −x. The effects that the simulation lacks move the tip mainly \
                 in that direction (" a href="#fig5" { "Fig. 5" } ")."
            },
            1 => html! {
                "Training that stops at the paper’s error agrees with it by construction. \
                 Converged networks have a smaller validation error."
            },
            2 => html! {
                "The network of π_real learns from real points only. The Gaussian process of A \
                 learns the difference between simulation and robot, which needs few points."
            },
            3 => self.path_tracking(),
            4 => self.numbers(),
            5 => self.comparisons(),
            _ => Markup::default(),
        }
    }

    fn path_tracking(&self) -> Markup {
        let switches = |training: &str| {
            let rows = self
                .tracks
                .iter()
                .filter(|row| row.policy == "c" && row.training == training && row.status.is_ok());
            mean(&rows.map(|row| row.switches as f64).collect::<Vec<_>>())
        };
        let (stopped, converged) = (switches("paper"), switches("converged"));
        html! {
            @if let Some(threshold_m) = self.switch_threshold_m {
                "C begins with A and switches between A and B where the error exceeds its threshold of "
                (millimetres(threshold_m)) " mm. "
            }
            @if stopped.is_finite() && converged.is_finite() {
                "It switches " (count(stopped)) " times on a path with stopped networks and "
                (count(converged)) " times with converged ones (mean over repetitions)"
                @if converged == 0.0 { ", where it therefore equals A" }
                ". "
            }
            (self.failed_tracks())
        }
    }

    /// The repetitions without a number.
    fn failed_tracks(&self) -> Markup {
        let failed: Vec<_> = self.tracks.iter().filter(|row| !row.status.is_ok()).collect();
        html! {
            @for row in failed {
                "Repetition " (row.seed + 1) " of " (policy_label(&row.policy)) " (" (training_label(&row.training))
                ") failed after " (format!("{:.0}", row.completion_time_s)) " s: " code { (row.status) }
                ". Claims about " (policy_label(&row.policy)) " with this training are undecided for lack of \
                 repetitions. "
            }
        }
    }

    fn numbers(&self) -> Markup {
        let open = |training: &str| self.mean_m(training, "a", "open");
        html! {
            @if let (Some(stopped_m), Some(converged_m)) = (open("paper"), open("converged")) {
                "Training to convergence alone changes the mean error of A in open loop from "
                (millimetres(stopped_m)) " to " (millimetres(converged_m)) " mm. What remains is split up in the "
                a href="#sweep_error_budget" { "error budget" } "."
            }
        }
    }

    fn comparisons(&self) -> Markup {
        let ranges = ["open", "closed", "closed_load"].map(|mode| self.range_m(mode));
        html! {
            @if let [Some(open), Some(closed), Some(load)] = ranges {
                "With converged networks the controllers have nearly equal mean errors: "
                (range(open)) " mm in open loop, " (range(closed)) " mm in closed loop and "
                (range(load)) " mm with a load."
            }
        }
    }

    fn mean_m(&self, training: &str, policy: &str, mode: &str) -> Option<f64> {
        let is_cell = |row: &&ReachSummaryRow| {
            row.training == training && row.cell.policy == policy && row.cell.mode == mode
        };
        self.table1.iter().find(is_cell).map(|row| row.mean_m)
    }

    /// Least and largest mean error of the controllers with converged networks.
    fn range_m(&self, mode: &str) -> Option<[f64; 2]> {
        let means: Vec<f64> = PAPER_POLICIES
            .iter()
            .filter_map(|policy| self.mean_m("converged", policy, mode))
            .collect();
        let low = means.iter().copied().fold(f64::INFINITY, f64::min);
        let high = means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (low <= high).then_some([low, high])
    }
}

/// How many claims are reproduced, by training.
pub(super) fn verdicts_by_training(lines: &[ClaimLine]) -> Markup {
    let sentence = |training: &str| {
        let rows =
            || lines.iter().flat_map(|line| &line.rows).filter(|row| row.training == training);
        let reproduced = rows().filter(|row| row.verdict == "reproduced").count();
        (rows().count(), reproduced)
    };
    let parts = [
        ("paper", "with stopped networks"),
        ("converged", "with converged networks"),
        (ANY_TRAINING, "independent of the training"),
    ];
    let parts: Vec<String> = parts
        .into_iter()
        .map(|(training, words)| (sentence(training), words))
        .filter(|((all, _), _)| *all > 0)
        .map(|((all, reproduced), words)| format!("{reproduced} of {all} {words}"))
        .collect();
    html! { "Reproduced: " (parts.join(", ")) "." }
}

fn millimetres(value_m: f64) -> String {
    format!("{:.1}", 1e3 * value_m)
}

fn range([low_m, high_m]: [f64; 2]) -> String {
    format!("{} to {}", millimetres(low_m), millimetres(high_m))
}

fn count(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1}") }
}
