//! The default figure of a sweep: lines of errors for one field, heat maps for two. One figure for each task with rows.

mod field;
mod heat;
mod lines;

use super::drawing::canvas::Canvas;
use super::style::{policy_label, training_label};
use super::{Artifact, Figure, Published, ReportError, pictures};
use crate::data::rows::SweepRow;
use field::SweptAxis;
use std::collections::HashMap;

/// Registry entry.
pub(super) const FIGURE: Figure =
    Figure { name: "sweep", about: "Error against one swept field, or two, for every policy and mode", render };

/// Tasks in the order of their figures, and the names of their errors.
const TASKS: [(&str, &str); 3] = [
    ("reach", "goal-reaching error (mm)"),
    ("track", "path tracking error (mm)"),
    ("gp", "cross-validation error (mm)"),
];

/// Initial height of a canvas; the final one is set after drawing.
const TALL: f64 = 1e6;

/// One row with the values of the swept fields.
struct SweepEntry<'a> {
    /// The cells of the swept fields.
    at: Vec<&'a str>,
    row: &'a SweepRow,
}

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let swept = &published.sweep;
    if swept.rows.is_empty() || swept.fields.is_empty() {
        return Err(ReportError::NoRows { figure: FIGURE.name, needs: "sweep.csv" });
    }
    if swept.fields.len() > 2 {
        let found = format!("{} swept fields", swept.fields.len());
        return Err(ReportError::Mixed { figure: FIGURE.name, found, expected: "or two of them" });
    }
    let fields: Vec<SweptAxis> = swept.fields.iter().map(|(name, cells)| SweptAxis::new(name, cells)).collect();
    let at = |row: usize| swept.fields.iter().filter_map(|(_, cells)| cells.get(row).map(String::as_str)).collect();
    let entries: Vec<SweepEntry> =
        swept.rows.iter().enumerate().map(|(index, row)| SweepEntry { at: at(index), row }).collect();
    let mut files = Vec::new();
    for (task, measure) in TASKS {
        let own: Vec<&SweepEntry> = entries.iter().filter(|entry| entry.row.task == task).collect();
        if own.is_empty() {
            continue;
        }
        let canvas: Canvas = match fields.as_slice() {
            [first, second] => heat::draw(&own, [first, second], measure),
            [first, ..] => lines::draw(&own, first, measure),
            [] => continue,
        };
        let stem = if files.is_empty() { FIGURE.name.to_owned() } else { format!("{}_{task}", FIGURE.name) };
        files.extend(pictures(FIGURE.name, &stem, &canvas)?);
    }
    if files.is_empty() {
        return Err(ReportError::NoRows { figure: FIGURE.name, needs: "sweep.csv of a known task" });
    }
    Ok(files)
}

/// A mode as a heading.
fn mode_label(mode: &str) -> String {
    match mode {
        "" => String::new(),
        "open" => "open loop".to_owned(),
        "closed" => "closed loop".to_owned(),
        "closed_load" => "closed loop with load".to_owned(),
        other => other.replace('_', " "),
    }
}

/// A kind of training as a heading.
fn training_heading(training: &str) -> String {
    if training == "any" { String::new() } else { training_label(training) }
}

/// Label of a line or a map within its training and mode: the policy, and its real points if it has several sizes.
fn series_label(row: &SweepRow, sized: bool) -> String {
    let points = row.gp_points.max(row.real_points);
    match (row.policy.as_str(), sized) {
        ("", true) => format!("{points} points"),
        ("", false) => "Gaussian process".to_owned(),
        (policy, true) => format!("{}, {points} points", policy_label(policy)),
        (policy, false) => policy_label(policy).to_owned(),
    }
}

/// Whether a policy has several sizes at one point.
fn sized(entries: &[&SweepEntry]) -> bool {
    let mut first = HashMap::new();
    entries.iter().any(|entry| {
        let row = entry.row;
        let sizes = (row.gp_points, row.real_points);
        *first.entry((&entry.at, &row.training, &row.policy, &row.mode)).or_insert(sizes) != sizes
    })
}
