//! What a laboratory would use instead of a rod: maps from commands to positions, fitted to the
//! same rows.

use std::cell::RefCell;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::constant_curvature;
use crate::base::{Point3, Rows};
use crate::calibration::compare::blocks::SightingSplit;
use crate::calibration::compare::comparison::Comparison;
use crate::effects::Model;
use crate::learn::gp::{Gp, GpConfig, RangeEnd};

/// Rows to which the hyper-parameters of a Gaussian process are fitted, and rows that it is
/// conditioned on.
const SEARCH_ROWS: usize = 250;
const MAX_ROWS: usize = 1200;
/// Ridges of a regression that are tried, as shares of the mean square of the features. The least
/// only leaves out directions without data.
const RIDGES: [f64; 6] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];

/// A reference model and what it says of sightings that it has not seen.
pub(crate) struct Reference {
    pub(crate) name: &'static str,
    /// Numbers fitted, a point each counted; none where that is no measure.
    pub(crate) numbers: usize,
    /// Predictions in the order of the asked sightings; none where it could not be fitted.
    pub(crate) positions: Option<Vec<Point3>>,
    /// Hyper-parameters at an end of their range, in words.
    pub(crate) range_ends: Vec<String>,
}

impl Reference {
    /// One whose fit has no hyper-parameters.
    fn plain(name: &'static str, numbers: usize, positions: Option<Vec<Point3>>) -> Reference {
        Reference { name, numbers, positions, range_ends: Vec::new() }
    }
}

/// Every reference model, fitted to the sightings `fitted` and asked for the sightings `asked`.
pub(crate) fn references(
    model: &Model,
    comparison: &Comparison,
    split: SightingSplit,
) -> Vec<Reference> {
    let data = Data::new(comparison);
    let linear = |quadratic: bool| {
        let parts = data.each_marker(split, &|x, y, query| regression(x, y, query, quadratic));
        parts.map(|(positions, numbers)| (Some(positions), numbers)).unwrap_or((None, 0))
    };
    let (linear_m, linear_numbers) = linear(false);
    let (quadratic_m, quadratic_numbers) = linear(true);
    let range_ends = RefCell::new(Vec::new());
    let gp = data.each_marker(split, &|x, y, query| {
        let (positions, ends) = gaussian_process(x, y, query)?;
        range_ends.borrow_mut().extend(ends);
        Some((positions, 0))
    });
    let arcs = constant_curvature::predictions(model, comparison, &data.commands, split);
    let (arcs_m, arcs_numbers) =
        arcs.map_or((None, 0), |(positions, numbers)| (Some(positions), numbers));
    vec![
        Reference::plain("constant curvature", arcs_numbers, arcs_m),
        Reference::plain("linear regression", linear_numbers, linear_m),
        Reference::plain("quadratic regression", quadratic_numbers, quadratic_m),
        Reference {
            name: "Gaussian process",
            numbers: 0,
            positions: gp.map(|(positions, _)| positions),
            range_ends: range_ends.into_inner(),
        },
    ]
}

/// Commands in force at each row, and the comparison.
struct Data<'a, 'b> {
    comparison: &'b Comparison<'a>,
    commands: Vec<Vec<f64>>,
}

/// A map fitted to rows of inputs and positions and asked for other inputs: its answers and its
/// numbers.
type Map<'a> = dyn Fn(&[&[f64]], &[Point3], &[&[f64]]) -> Option<(Vec<Point3>, usize)> + 'a;

impl<'a, 'b> Data<'a, 'b> {
    fn new(comparison: &'b Comparison<'a>) -> Data<'a, 'b> {
        Data { comparison, commands: commands_in_force(comparison) }
    }

    /// One map a tracked point.
    fn each_marker(
        &self,
        SightingSplit { fitted, unseen }: SightingSplit,
        map: &Map,
    ) -> Option<(Vec<Point3>, usize)> {
        let mut answers = vec![[f64::NAN; 3]; unseen.len()];
        let mut numbers = 0;
        for marker in 0..self.comparison.markers.len() {
            let of_marker = |index: &&usize| self.comparison.sightings[**index].marker == marker;
            let train: Vec<usize> = fitted.iter().filter(of_marker).copied().collect();
            let places: Vec<usize> = (0..unseen.len())
                .filter(|&k| self.comparison.sightings[unseen[k]].marker == marker)
                .collect();
            if places.is_empty() {
                continue;
            }
            let input =
                |index: usize| self.commands[self.comparison.sightings[index].row].as_slice();
            let x: Vec<&[f64]> = train.iter().map(|&index| input(index)).collect();
            let y: Vec<Point3> =
                train.iter().map(|&index| self.comparison.sightings[index].at_m).collect();
            let query: Vec<&[f64]> = places.iter().map(|&k| input(unseen[k])).collect();
            let (predicted_m, map_numbers) = map(&x, &y, &query)?;
            numbers += map_numbers;
            places.iter().zip(predicted_m).for_each(|(&k, at)| answers[k] = at);
        }
        Some((answers, numbers))
    }
}

/// For each row the commands that led to its pose: its own at rest, else those of the row before;
/// with the hung weight where that changes.
pub(crate) fn commands_in_force(comparison: &Comparison) -> Vec<Vec<f64>> {
    let recording = &comparison.recordings.joined;
    let weights =
        recording.known_load_kg.as_ref().filter(|all| all.iter().any(|mass_kg| *mass_kg != all[0]));
    let row = |row: usize| {
        let first = row == 0 || recording.trial[row] != recording.trial[row - 1];
        let mut command = match (comparison.at_rest, first) {
            (true, _) => recording.commands.row(row).to_vec(),
            (false, true) => vec![0.0; recording.tendons()],
            // A row of a motion holds the tip at the start of its command.
            (false, false) => recording.commands.row(row - 1).to_vec(),
        };
        command.extend(weights.map(|all| all[row]));
        command
    };
    (0..recording.len()).map(row).collect()
}

/// Ridge regression on the commands, or on them and their products.
fn regression(
    x: &[&[f64]],
    y: &[Point3],
    query: &[&[f64]],
    quadratic: bool,
) -> Option<(Vec<Point3>, usize)> {
    let width = x.first()?.len();
    let largest: Vec<f64> =
        (0..width).map(|d| x.iter().map(|row| row[d].abs()).fold(0.0, f64::max)).collect();
    let features = |row: &[f64]| -> Vec<f64> {
        let scaled: Vec<f64> = row
            .iter()
            .zip(&largest)
            .map(|(value, size)| if *size > 0.0 { value / size } else { 0.0 })
            .collect();
        let mut all = vec![1.0];
        all.extend(&scaled);
        if quadratic {
            (0..width).for_each(|a| all.extend((a..width).map(|b| scaled[a] * scaled[b])));
        }
        all
    };
    let rows: Vec<Vec<f64>> = x.iter().map(|row| features(row)).collect();
    let count = rows[0].len();
    let design = DMatrix::from_fn(rows.len(), count, |row, column| rows[row][column]);
    // About the mean: the ridge must not pull positions to the origin.
    let mean: Point3 =
        std::array::from_fn(|axis| y.iter().map(|at| at[axis]).sum::<f64>() / y.len() as f64);
    let targets = DMatrix::from_fn(rows.len(), 3, |row, axis| y[row][axis] - mean[axis]);
    let weights = ridge_weights(&design, &targets)?;
    let answer = |row: &&[f64]| -> Point3 {
        let features = DVector::from_vec(features(row));
        std::array::from_fn(|axis| mean[axis] + weights.column(axis).dot(&features))
    };
    Some((query.iter().map(answer).collect(), 3 * count))
}

/// Weights of a ridge regression, one column a target; the ridge is chosen by generalised
/// cross-validation (Golub, Heath & Wahba, Technometrics 21, 1979).
fn ridge_weights(design: &DMatrix<f64>, targets: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let normal = design.tr_mul(design);
    let scale = normal.trace() / normal.nrows() as f64;
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(normal);
    let along = eigenvectors.tr_mul(&design.tr_mul(targets));
    let error = |ridge: f64| {
        let (mut square, mut freedom) = (targets.norm_squared(), 0.0);
        for (along, &value) in along.row_iter().zip(&eigenvalues) {
            let filter = value / (value + ridge);
            square -= along.norm_squared() / (value + ridge) * (2.0 - filter);
            freedom += filter;
        }
        square / (design.nrows() as f64 - freedom).max(1.0).powi(2)
    };
    let ridge = RIDGES
        .map(|share| share * scale)
        .into_iter()
        .min_by(|&a, &b| error(a).total_cmp(&error(b)))
        .filter(|ridge| *ridge > 0.0)?;
    let mut filtered = along.clone();
    filtered
        .row_iter_mut()
        .zip(&eigenvalues)
        .for_each(|(mut row, value)| row.unscale_mut(value + ridge));
    Some(eigenvectors * filtered)
}

/// A Gaussian process (squared exponential, one length a command): hyper-parameters from some rows,
/// conditioned on all. Beside its answers the hyper-parameters at an end of their range, in words.
fn gaussian_process(
    x: &[&[f64]],
    y: &[Point3],
    query: &[&[f64]],
) -> Option<(Vec<Point3>, Vec<String>)> {
    let table = |rows: &[usize]| {
        let (mut inputs, mut outputs) = (Rows::new(x.first()?.len()), Rows::new(3));
        rows.iter().for_each(|&row| {
            inputs.push(x[row]);
            outputs.push(&y[row]);
        });
        Some((inputs, outputs))
    };
    let evenly = |max_rows: usize| -> Vec<usize> {
        let count = x.len().min(max_rows);
        (0..count).map(|k| k * x.len() / count).collect()
    };
    let config = GpConfig { starts: 2, ..GpConfig::default() };
    let (inputs, outputs) = table(&evenly(SEARCH_ROWS))?;
    // The search costs the cube of the rows, conditioning only once.
    let searched = Gp::fit(&inputs, &outputs, &config).ok()?;
    let (inputs, outputs) = table(&evenly(MAX_ROWS))?;
    let gp = Gp::condition(&inputs, &outputs, &config, searched.theta().to_vec(), 0).ok()?;
    let answer = |row: &&[f64]| -> Option<Point3> { gp.mean(row).ok()?.try_into().ok() };
    let ends = searched.range_ends().iter().map(RangeEnd::describe).collect();
    Some((query.iter().map(answer).collect::<Option<_>>()?, ends))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    #[test]
    fn a_ridge_foretells_what_few_noisy_rows_with_many_features_do_not_tell() {
        use rand::RngExt;

        let mut random = Seed(5).rng();
        let mut drawn = |size: f64| -> f64 { random.random_range(-size..=size) };
        let x: Vec<Vec<f64>> = (0..150).map(|_| (0..9).map(|_| drawn(1.0)).collect()).collect();
        let truth = |row: &[f64]| [row[0] + 0.3 * row[1] * row[2], row[3] - row[4], 5.0];
        let y: Vec<Point3> = x.iter().map(|row| truth(row).map(|at| at + drawn(0.5))).collect();
        let rows: Vec<&[f64]> = x.iter().map(Vec::as_slice).collect();
        // Half of the rows carry 55 weights; the others judge.
        let (answers, numbers) = regression(&rows[..75], &y[..75], &rows[75..], true).unwrap();
        assert_eq!(numbers, 3 * 55);
        let square = |at: &Point3, row: &&[f64]| {
            at.iter().zip(truth(row)).map(|(at, truth)| (at - truth).powi(2)).sum::<f64>()
        };
        let error = answers.iter().zip(&rows[75..]).map(|(at, row)| square(at, row)).sum::<f64>();
        let spread = rows[75..].iter().map(|row| square(&[0.0, 0.0, 5.0], row)).sum::<f64>();
        assert!(error < 0.5 * spread, "{error} of {spread}");
    }
}
