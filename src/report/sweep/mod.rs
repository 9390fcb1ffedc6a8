//! The default figure of a sweep: lines of errors for one field, heat maps for two, and for each
//! value of a third. One figure for each task with rows.

pub(super) mod comparisons;
mod field;
mod heat;
mod lines;
pub(super) mod rows;
mod words;

use super::drawing::Canvas;
use super::order::trainings;
use super::style::{PAGE_WIDTH, capitalised, policy_label, training_label};
use super::{Artifact, Figure, Published, ReportError, captioned};
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
        // Of a later task that no field changes there is nothing to see.
        if of_task.is_empty() || (!files.is_empty() && is_constant(&of_task)) {
            continue;
        }
        let draw = |width: f64| match fields.as_slice() {
            [first, second] => {
                heat::draw(&[(String::new(), of_task.clone())], [first, second], measure, width)
            }
            [third, first, second] => {
                heat::draw(&blocks(third, &of_task), [first, second], measure, width)
            }
            [first, ..] => lines::draw(&of_task, first, measure, width),
            [] => Canvas::new(width, 1.0),
        };
        let stem = if files.is_empty() {
            FIGURE.name.to_owned()
        } else {
            format!("{}_{task}", FIGURE.name)
        };
        files.extend(captioned(FIGURE.name, &stem, &caption(&of_task, &fields, measure), draw)?);
    }
    FIGURE.needs("sweep.csv of a known task", files.is_empty())?;
    Ok(files)
}

/// Whether every policy has the same errors at all points.
fn is_constant(entries: &[&SweepEntry]) -> bool {
    let mut first = HashMap::new();
    entries.iter().all(|entry| {
        let row = entry.row;
        let mean_m = row.mean_m.to_bits();
        let cell = (&row.training, &row.cell.policy, &row.cell.mode);
        *first.entry(cell).or_insert(mean_m) == mean_m
    })
}

fn caption(entries: &[&SweepEntry], fields: &[SweptAxis], measure: &str) -> String {
    let names: Vec<String> = fields.iter().map(|field| field.label(f64::INFINITY)).collect();
    let trainings = trainings(
        entries.iter().map(|entry| entry.row.training.as_str()).filter(|name| *name != "any"),
    );
    let trained: Vec<String> = trainings.into_iter().map(training_label).collect();
    let trained =
        if trained.is_empty() { String::new() } else { format!("; {}", trained.join(", and ")) };
    let seeds = entries.iter().map(|entry| entry.row.seeds).max().unwrap_or(0);
    let marks = if fields.len() == 1 {
        "Marks are means, bars and bands one standard deviation over repetitions."
    } else {
        "Numbers are means in mm; the colour is the error over the smallest one of its map, on one \
         scale; –: every trial failed."
    };
    let kernels = if names.iter().any(|name| name == "kernel") {
        " SE: squared exponential; ARD: one length scale for each input."
    } else {
        ""
    };
    format!(
        "{} by {} over {seeds} repetitions{trained}. {marks}{kernels}",
        capitalised(measure),
        names.join(" and ")
    )
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
