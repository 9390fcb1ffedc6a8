//! The default figure of a sweep: lines of errors for one field, heat maps for two, and for each
//! value of a third. One figure for each task with rows.

pub(super) mod comparisons;
mod field;
mod heat;
mod lines;
pub(super) mod rows;

use super::drawing::Canvas;
use super::style::{PAGE_WIDTH, policy_label, training_label};
use super::{Artifact, Figure, Published, ReportError, pictures};
use crate::rows::experiment::SweepRow;
use field::SweptAxis;
use std::collections::HashMap;

/// Registry entry.
pub(super) const FIGURE: Figure = Figure {
    name: "sweep",
    about: "Error against one, two or three swept fields, for every policy and mode",
    render,
};

/// Tasks in the order of their figures, and the names of their errors.
const TASKS: [(&str, &str); 4] = [
    ("reach", "goal-reaching error (mm)"),
    ("response", "error at the end of a response (mm)"),
    ("track", "path tracking error (mm)"),
    ("gp", "cross-validation error (mm)"),
];

/// One row with the values of the swept fields.
struct SweepEntry<'a> {
    /// The cells of the swept fields.
    at: Vec<&'a str>,
    row: &'a SweepRow,
}

fn render(published: &Published) -> Result<Vec<Artifact>, ReportError> {
    let swept = &published.sweep;
    FIGURE.needs("sweep.csv", swept.rows.is_empty() || swept.fields.is_empty())?;
    if swept.fields.len() > 3 {
        let found = format!("{} swept fields", swept.fields.len());
        return Err(ReportError::Mixed {
            figure: FIGURE.name,
            found,
            expected: "to three of them",
        });
    }
    let fields: Vec<SweptAxis> =
        swept.fields.iter().map(|(name, cells)| SweptAxis::new(name, cells)).collect();
    let at = |row: usize| {
        swept.fields.iter().filter_map(|(_, cells)| cells.get(row).map(String::as_str)).collect()
    };
    let entries: Vec<SweepEntry> = swept
        .rows
        .iter()
        .enumerate()
        .map(|(index, row)| SweepEntry { at: at(index), row })
        .collect();
    let mut files = Vec::new();
    for (task, measure) in TASKS {
        let of_task: Vec<&SweepEntry> =
            entries.iter().filter(|entry| entry.row.task == task).collect();
        if of_task.is_empty() {
            continue;
        }
        let canvas: Canvas = match fields.as_slice() {
            [first, second] => heat::draw(&[(String::new(), of_task)], [first, second], measure),
            [third, first, second] => {
                heat::draw(&blocks(third, &of_task), [first, second], measure)
            }
            [first, ..] => lines::draw(&of_task, first, measure),
            [] => continue,
        };
        let stem = if files.is_empty() {
            FIGURE.name.to_owned()
        } else {
            format!("{}_{task}", FIGURE.name)
        };
        files.extend(pictures(FIGURE.name, &stem, &canvas)?);
    }
    FIGURE.needs("sweep.csv of a known task", files.is_empty())?;
    Ok(files)
}

/// The rows of each value of the first field, with a heading.
fn blocks<'a>(
    field: &SweptAxis,
    entries: &[&'a SweepEntry<'a>],
) -> Vec<(String, Vec<&'a SweepEntry<'a>>)> {
    let block = |value: &String| {
        let of_value =
            entries.iter().copied().filter(|entry| entry.at.first() == Some(&value.as_str()));
        (
            format!("{} = {}", field.label(PAGE_WIDTH), field.shown(value, PAGE_WIDTH)),
            of_value.collect(),
        )
    };
    field.values.iter().map(block).collect()
}

/// A kind of training as a heading.
fn training_heading(training: &str) -> String {
    if training == "any" { String::new() } else { training_label(training) }
}

/// Label of a line or a map within its training and mode: the policy, and its real points if it has
/// several sizes.
fn series_label(row: &SweepRow, sized: bool) -> String {
    let points = row.cell.gp_points.max(row.cell.real_points);
    match (row.cell.policy.as_str(), sized) {
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
        let sizes = (row.cell.gp_points, row.cell.real_points);
        *first.entry((&entry.at, &row.training, &row.cell.policy, &row.cell.mode)).or_insert(sizes)
            != sizes
    })
}
