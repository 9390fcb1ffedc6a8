//! The error on rows that the fit has not seen, beside that of what a laboratory would use instead.

use std::collections::BTreeMap;

use nalgebra::{DVector, Vector3};

use super::baselines::{Reference, references};
use crate::base::Point3;
use crate::calibration::compare::blocks::{Blocks, SightingSplit};
use crate::calibration::compare::comparison::{Comparison, Positions};
use crate::calibration::fit::intervals::inverse;
use crate::calibration::fit::optimum::{CalibrationProblem, Optimum};
use crate::data::calibration::{HeldOutError, ModelError};
use crate::effects::Model;
use crate::math::summary::root_mean_square;

/// Predictions of sightings that were not fitted, one list a model.
struct Unseen {
    name: &'static str,
    numbers: usize,
    /// Index of a sighting and what the model says of it.
    positions: Vec<(usize, Option<Point3>)>,
    /// Whether it could be fitted in every part.
    complete: bool,
    /// Hyper-parameters at an end of their range, of all parts.
    range_ends: Vec<String>,
}

/// Blocked cross-validation. For each part the numbers are those of a fit without it, from one
/// Gauss–Newton step at the optimum of all rows (exact where the model is linear; Giordano et al.
/// 2019, the infinitesimal jackknife), and the part is then simulated with them.
pub(crate) fn cross_validated(
    problem: &CalibrationProblem,
    best: &Optimum,
    blocks: &Blocks,
) -> HeldOutError {
    let folds = blocks.folds();
    let mut all: Vec<Unseen> = Vec::new();
    for fold in &folds {
        let (unseen, fitted) = blocks.parted(fold);
        let part = problem.comparison.only(&unseen);
        let x = without(problem, best, &unseen);
        let model = problem.at(&x).or_else(|| problem.at(&best.x));
        let fitted_m =
            model.map_or_else(|| vec![None; unseen.len()], |model| part.positions(&model));
        add(&mut all, "this model, fitted", problem.numbers.len(), &unseen, Some(fitted_m));
        let start = problem.at(&vec![0.0; best.x.len()]);
        add(
            &mut all,
            "this model, as given",
            0,
            &unseen,
            start.map(|model| part.positions(&model)),
        );
        add_references(
            &mut all,
            problem.model,
            problem.comparison,
            SightingSplit { fitted: &fitted, unseen: &unseen },
        );
    }
    let how = format!(
        "blocked cross-validation: {} parts of the {} {}s",
        folds.len(),
        blocks.names.len(),
        blocks.kind
    );
    error(problem.comparison, how, Vec::new(), all)
}

/// Error on the unseen sightings of `whole`.
pub(crate) fn held_out(
    problem: &CalibrationProblem,
    best: &Optimum,
    whole: &Comparison,
    split: SightingSplit,
    (kind, names): (&str, Vec<String>),
) -> HeldOutError {
    let unseen = whole.only(split.unseen);
    let mut all: Vec<Unseen> = Vec::new();
    let positions = |x: &[f64]| problem.at(x).map(|model| unseen.positions(&model));
    add(&mut all, "this model, fitted", problem.numbers.len(), split.unseen, positions(&best.x));
    add(&mut all, "this model, as given", 0, split.unseen, positions(&vec![0.0; best.x.len()]));
    add_references(&mut all, problem.model, whole, split);
    error(whole, format!("{} {kind}s held out of the fit", names.len()), names, all)
}

/// Coordinates of a fit without some sightings.
pub(crate) fn without(
    problem: &CalibrationProblem,
    best: &Optimum,
    left_out: &[usize],
) -> Vec<f64> {
    let (mut normal, mut gradient) = problem.normal(best);
    for &index in left_out {
        // Downdate the normal equations by the equations that are left out.
        let (rows, weight) = (best.slopes.rows(3 * index, 3), best.weights[index]);
        normal -= rows.tr_mul(&rows) * weight;
        gradient -= rows.tr_mul(&best.residual_m.rows(3 * index, 3)) * weight;
    }
    let Some(inverse) = inverse(&normal) else { return best.x.clone() };
    let step: DVector<f64> = -(inverse.inverse * gradient);
    let longest = |(number, step): (&crate::calibration::numbers::number::FitNumber, &f64)| {
        step.abs() / number.longest_step()
    };
    // A linear step may lead far outside where the model is linear.
    let shorten = problem.numbers.iter().zip(step.iter()).map(longest).fold(1.0, f64::max);
    let moved = best.x.iter().zip(step.iter()).zip(problem.numbers);
    moved.map(|((x, step), number)| (x + step / shorten).max(number.low())).collect()
}

fn add_references(
    all: &mut Vec<Unseen>,
    model: &Model,
    comparison: &Comparison,
    split: SightingSplit,
) {
    for Reference { name, numbers, positions, range_ends } in references(model, comparison, split) {
        let positions = positions.map(|all| all.into_iter().map(Some).collect());
        add(all, name, numbers, split.unseen, positions).range_ends.extend(range_ends);
    }
}

fn add<'a>(
    all: &'a mut Vec<Unseen>,
    name: &'static str,
    numbers: usize,
    unseen: &[usize],
    positions: Option<Positions>,
) -> &'a mut Unseen {
    let place = all.iter().position(|one| one.name == name).unwrap_or_else(|| {
        let (positions, range_ends) = (Vec::new(), Vec::new());
        all.push(Unseen { name, numbers, positions, complete: true, range_ends });
        all.len() - 1
    });
    let one = &mut all[place];
    one.numbers = one.numbers.max(numbers);
    match positions {
        Some(positions) => one.positions.extend(unseen.iter().copied().zip(positions)),
        None => one.complete = false,
    }
    one
}

fn error(
    comparison: &Comparison,
    how: String,
    names: Vec<String>,
    all: Vec<Unseen>,
) -> HeldOutError {
    let sightings = &comparison.sightings;
    let errors_m = |one: &Unseen, marker: usize| -> Vec<Vector3<f64>> {
        let of_marker = one.positions.iter().filter(|(k, _)| sightings[*k].marker == marker);
        of_marker
            .filter_map(|(k, at)| Some(Vector3::from((*at)?) - Vector3::from(sightings[*k].at_m)))
            .collect()
    };
    let model = |one: &Unseen| {
        let markers = 0..comparison.markers.len();
        let by_marker: Vec<_> = markers.map(|marker| errors_m(one, marker)).collect();
        // A model that failed in one part must not be compared on the easier rest.
        let if_complete = |size_m: f64| if one.complete { size_m } else { f64::NAN };
        ModelError {
            name: one.name.to_owned(),
            numbers: one.numbers,
            rms_m: if_complete(rms_m(&by_marker.concat())),
            rms_without_mean_m: if_complete(rms_m(
                &by_marker.iter().flat_map(|errors_m| centred(errors_m)).collect::<Vec<_>>(),
            )),
            by_point_m: by_marker.iter().map(|errors_m| if_complete(rms_m(errors_m))).collect(),
            at_range_end: counted(&one.range_ends),
        }
    };
    let rows = all.first().map_or(0, |one| one.positions.len());
    HeldOutError {
        how,
        names,
        positions: rows,
        points: comparison.markers.clone(),
        models: all.iter().map(model).collect(),
    }
}

/// Each text once, with how often it is there: `noise variance low (2)`.
fn counted(texts: &[String]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    texts.iter().for_each(|text| *counts.entry(text).or_default() += 1);
    let each: Vec<String> =
        counts.into_iter().map(|(text, count)| format!("{text} ({count})")).collect();
    each.join("; ")
}

/// Root mean square length.
fn rms_m(errors_m: &[Vector3<f64>]) -> f64 {
    root_mean_square(&errors_m.iter().map(Vector3::norm).collect::<Vec<f64>>())
}

/// The errors without their mean.
fn centred(errors_m: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mean_m = errors_m.iter().sum::<Vector3<f64>>() / errors_m.len() as f64;
    errors_m.iter().map(|error_m| error_m - mean_m).collect()
}
