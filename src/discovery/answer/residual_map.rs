//! Every sample with its residuals, and the residual map: samples grouped by tracked place,
//! workspace, time, direction of motion, tension and history, each group with its residual and
//! p-value.

use crate::data::findings::{Disagreement, PlaceRow, ResidualRow};
use crate::discovery::fit::ar1_noise::Ar1Noise;
use crate::discovery::recording::covariates::Covariates;
use crate::discovery::recording::samples::{Sample, Samples};
use crate::math::distribution::{chi_squared_above, holm};
use crate::math::summary::quantile;

/// A group of samples.
struct SampleGroup {
    by: &'static str,
    name: String,
    rows: Vec<usize>,
}

/// Minimum number of samples of a group.
const MIN_GROUP_SAMPLES: usize = 8;
const AXES: [&str; 4] = ["x", "y", "z", "all"];

/// A row for each sample: its residuals before and after, three values a sample, metres. `points`:
/// names of the model's points.
pub(crate) fn residual_rows(
    samples: &Samples,
    points: &[String],
    [before_m, after_m]: [&[f64]; 2],
    is_held_out: &dyn Fn(usize) -> bool,
) -> Vec<ResidualRow> {
    let row = |((sample, before), after): ((&Sample, &[f64; 3]), &[f64; 3])| ResidualRow {
        trial: samples.trials[sample.trial].number,
        time_s: sample.time_s,
        held_out: is_held_out(sample.trial),
        point: sample.point.map(|point| points[point].clone()).unwrap_or_default(),
        tip_x_m: sample.position_m[0],
        tip_y_m: sample.position_m[1],
        tip_z_m: sample.position_m[2],
        before_x_m: before[0],
        before_y_m: before[1],
        before_z_m: before[2],
        after_x_m: after[0],
        after_y_m: after[1],
        after_z_m: after[2],
    };
    samples
        .rows
        .iter()
        .zip(before_m.as_chunks::<3>().0)
        .zip(after_m.as_chunks::<3>().0)
        .map(row)
        .collect()
}

/// The map: every group along every axis and all together, before and after. `residuals`: rows of
/// the samples of these `covariates`; `points`: names of the model's points.
pub(crate) fn residual_map(
    covariates: &[Covariates],
    points: &[String],
    residuals: &[ResidualRow],
    noise: &Ar1Noise,
) -> Vec<PlaceRow> {
    let before_m: Vec<f64> = residuals.iter().flat_map(ResidualRow::before_m).collect();
    let after_m: Vec<f64> = residuals.iter().flat_map(ResidualRow::after_m).collect();
    let mut map = Vec::new();
    for group in
        groups(covariates, points).iter().filter(|group| group.rows.len() >= MIN_GROUP_SAMPLES)
    {
        for (axis, name) in AXES.into_iter().enumerate() {
            let (mean_before_m, rms_before_m, p_before) =
                summarise(&group.rows, &before_m, axis, noise);
            let (mean_after_m, rms_after_m, p_after) =
                summarise(&group.rows, &after_m, axis, noise);
            map.push(PlaceRow {
                by: group.by.to_owned(),
                place: group.name.clone(),
                axis: name.to_owned(),
                samples: group.rows.len() as u64,
                mean_before_m,
                rms_before_m,
                p_before,
                mean_after_m,
                rms_after_m,
                p_after,
                floor_m: if axis < 3 { noise.sigma_m[axis] } else { noise.rms_m() },
            });
        }
    }
    // Holm's correction for the number of groups, for the residuals before and after apart.
    let corrected = |p: &dyn Fn(&PlaceRow) -> f64| holm(&map.iter().map(p).collect::<Vec<f64>>());
    let (p_before, p_after) = (corrected(&|row| row.p_before), corrected(&|row| row.p_after));
    for (row, (before, after)) in map.iter_mut().zip(p_before.into_iter().zip(p_after)) {
        (row.p_before, row.p_after) = (before, after);
    }
    map
}

/// The groups of the map, largest residual over noise first.
pub(crate) fn disagreements(map: &[PlaceRow]) -> Vec<Disagreement> {
    let squares = |row: &PlaceRow| row.samples as f64 * row.rms_before_m.powi(2);
    let whole = map.iter().find(|row| row.by == "all" && row.axis == "all").map_or(0.0, squares);
    // Single axes tell where; the row of all samples and axes gives the total.
    let mut rows: Vec<&PlaceRow> =
        map.iter().filter(|row| row.axis != "all" || row.by == "all").collect();
    let excess = |row: &PlaceRow| row.rms_before_m / row.floor_m;
    rows.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
    let disagreement = |row: &&PlaceRow| Disagreement {
        place: if row.by == "all" {
            "all samples".to_owned()
        } else {
            format!("{}: {}", row.by, row.place)
        },
        axis: row.axis.clone(),
        rms_m: row.rms_before_m,
        share: if whole > 0.0 { squares(row) / whole } else { 0.0 },
        p_value: row.p_before,
    };
    rows.iter().map(disagreement).collect()
}

/// Mean, rms, and p-value against noise.
fn summarise(rows: &[usize], residual: &[f64], axis: usize, noise: &Ar1Noise) -> (f64, f64, f64) {
    let axes = if axis < 3 { axis..axis + 1 } else { 0..3 };
    let count = rows.len() as f64;
    let values = |axis: usize| rows.iter().map(move |&row| residual[3 * row + axis]);
    let squares: f64 = axes.clone().flat_map(values).map(|r| r * r).sum();
    let scaled: f64 = axes
        .clone()
        .map(|axis| values(axis).map(|r| (r / noise.sigma_m[axis]).powi(2)).sum::<f64>())
        .sum();
    // Squares of correlated samples are correlated by the square.
    let square = noise.correlation * noise.correlation;
    // Bartlett's effective number of samples for a correlation of ρ².
    let independent = (1.0 - square) / (1.0 + square);
    let freedom = count * axes.len() as f64 * independent;
    let mean_m = if axis < 3 { values(axis).sum::<f64>() / count } else { f64::NAN };
    let spread = chi_squared_above(scaled * independent, freedom);
    (mean_m, (squares / count).sqrt(), spread)
}

fn groups(covariates: &[Covariates], points: &[String]) -> Vec<SampleGroup> {
    let mut groups = vec![SampleGroup {
        by: "all",
        name: "all samples".to_owned(),
        rows: (0..covariates.len()).collect(),
    }];
    let mut add = |by: &'static str, name: String, kept: &dyn Fn(&Covariates) -> bool| {
        let rows = (0..covariates.len()).filter(|&row| kept(&covariates[row])).collect();
        groups.push(SampleGroup { by, name, rows });
    };
    if covariates.iter().any(|at| at.point.is_some()) {
        add("tracked place", "tip".to_owned(), &|at| at.point.is_none());
        for (index, name) in points.iter().enumerate() {
            add("tracked place", name.clone(), &|at| at.point == Some(index));
        }
    }
    for axis in 0..3 {
        // The median splits the samples into groups of equal power.
        let middle =
            quantile(&covariates.iter().map(|at| at.position_m[axis]).collect::<Vec<f64>>(), 0.5);
        let mm = whole_mm(middle);
        add("workspace", format!("{} below {mm} mm", AXES[axis]), &|at| {
            at.position_m[axis] < middle
        });
        add("workspace", format!("{} above {mm} mm", AXES[axis]), &|at| {
            at.position_m[axis] >= middle
        });
    }
    let longest = covariates.iter().map(|at| at.time_s).fold(0.0, f64::max);
    for (third, name) in ["first third", "second third", "last third"].into_iter().enumerate() {
        let (start, end) = (longest * third as f64 / 3.0, longest * (third + 1) as f64 / 3.0);
        let last = third == 2;
        add("time in trial", name.to_owned(), &|at| {
            at.time_s >= start && (at.time_s < end || last)
        });
    }
    for axis in 0..3 {
        for (sign, word) in [(1.0, "rising"), (-1.0, "falling")] {
            add("direction of motion", format!("{} {word}", AXES[axis]), &|at| {
                sign * at.moved_m[axis] > 1e-6
            });
        }
    }
    let pull = |at: &Covariates| at.command.iter().copied().fold(0.0, f64::max);
    let pulls: Vec<f64> = covariates.iter().map(pull).collect();
    // Thirds of the samples, so that no group is too small to test.
    let (low, high) = (quantile(&pulls, 1.0 / 3.0), quantile(&pulls, 2.0 / 3.0));
    add("largest pull", "small".to_owned(), &|at| pull(at) < low);
    add("largest pull", "middling".to_owned(), &|at| pull(at) >= low && pull(at) < high);
    add("largest pull", "large".to_owned(), &|at| pull(at) >= high);
    let reversed = |at: &Covariates| {
        at.change.iter().zip(&at.change_before).any(|(now, before)| now * before < 0.0)
    };
    let further = |at: &Covariates| {
        at.command.iter().zip(&at.largest).any(|(now, largest)| *now > 0.0 && now >= largest)
    };
    add("history", "a tendon has just reversed".to_owned(), &reversed);
    add("history", "no tendon has just reversed".to_owned(), &|at| !reversed(at));
    add("history", "further out than before".to_owned(), &further);
    add("history", "where it has been before".to_owned(), &|at| !further(at));
    groups
}

/// A length in whole millimetres with a true minus sign, and none before zero.
fn whole_mm(length_m: f64) -> String {
    let mm = (1e3 * length_m).round();
    format!("{}{:.0}", if mm < 0.0 { "−" } else { "" }, mm.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_below_minus_zero() {
        assert_eq!([-0.0002, 0.0004, -0.0124, 0.212].map(whole_mm), ["0", "0", "−12", "212"]);
    }
}
