//! The tip that a model predicts between rows, and how well it fits when all tips are measured at
//! other times.

use nalgebra::{DMatrix, DVector};

use crate::base::{Point3, Rows};
use crate::data::Recording;
use crate::discovery::fit::simulate;
use crate::discovery::recording::samples::{Sample, Samples};
use crate::effects::Model;

/// Predicted tips are computed this many times a step.
const SUBSTEPS: usize = 8;
/// Steps after the last command that are predicted.
const STEPS_AFTER: usize = 4;
/// Numbers an axis of the correction: a constant, and a factor for each coordinate of the
/// prediction.
const LINEAR: usize = 4;

/// A recording beside the prediction of a model, at any time.
pub(crate) struct TimeScan {
    /// Median step, seconds.
    pub(crate) step_s: f64,
    /// Trial (an index), time and measured tip of each row with a tip.
    rows: Vec<(usize, f64, Point3)>,
    /// Times and predicted tips of each trial.
    predicted: Vec<Vec<(f64, Point3)>>,
}

/// A fit at one offset.
pub(crate) struct ScanFit {
    /// Sum of squares, square metres.
    pub(crate) squares_m2: f64,
    /// Correlation of the residual from one row to the next.
    pub(crate) correlation: f64,
}

impl TimeScan {
    /// Predicts the trials of `measured`; none where the model cannot follow or nothing was
    /// tracked.
    pub(crate) fn new(model: &Model, measured: &Recording) -> Option<TimeScan> {
        let samples = Samples::new(measured);
        let step_s = samples.step_s;
        let trials = measured.trials();
        let place = |number: u64| trials.iter().position(|(other, _)| *other == number);
        let row = |sample: &Sample| {
            Some((place(samples.trials[sample.trial].number)?, sample.time_s, sample.position_m))
        };
        let rows: Vec<(usize, f64, Point3)> = samples.rows.iter().filter_map(row).collect();
        let fine = Samples::new(&subdivided(measured, step_s));
        let tips_m = simulate::tips(model, &[], &fine)?;
        let mut predicted = vec![Vec::new(); trials.len()];
        for (sample, tip_m) in fine.rows.iter().zip(tips_m.as_chunks::<3>().0) {
            predicted[sample.trial].push((sample.time_s, *tip_m));
        }
        (!rows.is_empty()).then_some(TimeScan { step_s, rows, predicted })
    }

    /// Number of rows with a tip.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Fits the measured tips by a linear function of the tip predicted `offset_s` after their
    /// rows. It stands for every effect that changes where the robot goes. `lagging` adds the last
    /// step's motion, for effects that change when.
    pub(crate) fn fit(&self, offset_s: f64, lagging: bool) -> Option<ScanFit> {
        let at = |trial: usize, time_s: f64| interpolate(&self.predicted[trial], time_s);
        let here: Vec<Point3> =
            self.rows.iter().map(|(trial, time_s, _)| at(*trial, time_s + offset_s)).collect();
        let back = |steps: f64| -> Vec<Point3> {
            self.rows
                .iter()
                .map(|(trial, time_s, _)| at(*trial, time_s + offset_s - steps * self.step_s))
                .collect()
        };
        // Half a step and a whole step back cover lags of different length.
        let past = if lagging { vec![back(0.5), back(1.0)] } else { Vec::new() };
        let mut residual_m = Vec::new();
        for axis in 0..3 {
            let column = |row: usize, column: usize| match column {
                0 => 1.0,
                1..LINEAR => here[row][column - 1],
                _ => here[row][axis] - past[column - LINEAR][row][axis],
            };
            let design = DMatrix::from_fn(self.rows.len(), LINEAR + past.len(), column);
            let measured = DVector::from_iterator(
                self.rows.len(),
                self.rows.iter().map(|(_, _, tip_m)| tip_m[axis]),
            );
            // A robot that moves in a plane leaves columns dependent, so no normal equations.
            let numbers = design.clone().svd(true, true).solve(&measured, 1e-12).ok()?;
            residual_m.push(measured - design * numbers);
        }
        let squares_m2: f64 = residual_m.iter().map(DVector::norm_squared).sum();
        let products = |axis_m: &DVector<f64>| -> f64 {
            // Rows of different trials do not follow each other.
            let same = |row: &usize| self.rows[*row].0 == self.rows[row - 1].0;
            (1..self.rows.len()).filter(same).map(|row| axis_m[row] * axis_m[row - 1]).sum()
        };
        let correlation =
            residual_m.iter().map(products).sum::<f64>() / squares_m2.max(f64::MIN_POSITIVE);
        Some(ScanFit { squares_m2, correlation })
    }
}

/// The commands of `measured` with [`SUBSTEPS`] rows a step, and some after the last. Every row
/// counts as tracked.
fn subdivided(measured: &Recording, step_s: f64) -> Recording {
    let mut fine = Recording::new(measured.actuation, measured.tendons());
    let mut of = Vec::new();
    let mut commands = Rows::new(measured.tendons());
    for (index, (_, range)) in measured.trials().into_iter().enumerate() {
        for row in range.clone() {
            let (time_s, is_last) = (measured.time_s[row], row + 1 == range.end);
            let length_s = if is_last { step_s } else { measured.time_s[row + 1] - time_s };
            // An offset looks beyond the last row, where its command still acts.
            for part in 0..if is_last { STEPS_AFTER * SUBSTEPS } else { SUBSTEPS } {
                of.push(row);
                fine.trial.push(index as u64);
                fine.time_s.push(time_s + length_s * part as f64 / SUBSTEPS as f64);
                commands.push(measured.commands.row(row));
            }
        }
    }
    fine.commands = commands;
    fine.tip_m = Some(vec![[0.0; 3]; of.len()]);
    fine.known_load_kg =
        measured.known_load_kg.as_ref().map(|load| of.iter().map(|&row| load[row]).collect());
    fine.gravity_m_s2 =
        measured.gravity_m_s2.as_ref().map(|gravity| of.iter().map(|&row| gravity[row]).collect());
    fine.tip_load =
        measured.tip_load.as_ref().map(|load| of.iter().map(|&row| load[row]).collect());
    fine
}

/// The predicted tip at a time, by straight lines; the first or last one outside.
fn interpolate(predicted: &[(f64, Point3)], time_s: f64) -> Point3 {
    let after = predicted.partition_point(|(at_s, _)| *at_s <= time_s);
    let (Some(from), Some(to)) = (after.checked_sub(1).map(|k| predicted[k]), predicted.get(after))
    else {
        return predicted[after.min(predicted.len() - 1)].1;
    };
    let share = (time_s - from.0) / (to.0 - from.0);
    std::array::from_fn(|axis| from.1[axis] + share * (to.1[axis] - from.1[axis]))
}
