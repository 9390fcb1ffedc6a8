//! Plausibility checks of recordings: units, durations, payloads.

use std::path::Path;

use super::extra::cell_error;
use super::{Actuation, Recording, read};
use crate::data::DataError;

/// Longest total duration of the trials, seconds: six hours.
const LONGEST_S: f64 = 6.0 * 3600.0;
/// Longest plausible median step, seconds.
const LONGEST_STEP_S: f64 = 60.0;

/// `path` is the file that the recording was read from.
impl Recording {
    /// Refuses tips and tracked points farther from the base at `base_m` than twice the length of the robot: usually millimetres instead
    /// of metres.
    ///
    /// # Errors
    /// [`DataError::Cell`] for the first such row.
    pub fn check_reach(&self, path: &Path, base_m: [f64; 3], length_m: f64) -> Result<(), DataError> {
        let points = self.points.iter().map(|point| (point.position_columns(), &point.position_m));
        let tip = self.tip_m.iter().map(|tips_m| (read::TIP.map(str::to_owned), tips_m));
        for (columns, positions_m) in tip.chain(points) {
            for (row, position_m) in positions_m.iter().enumerate().filter(|&(row, _)| self.is_valid(row)) {
                let far = |&axis: &usize| (position_m[axis] - base_m[axis]).abs() > 2.0 * length_m;
                let Some(axis) = (0..3).find(far) else { continue };
                let expected = format!("metres within reach of a robot of {length_m} m (are these millimetres?)");
                return Err(cell_error(path, row, &columns[axis], position_m[axis].to_string(), expected));
            }
        }
        Ok(())
    }

    /// Refuses displacements beyond twice the length of the robot: usually millimetres instead of metres. Tensions are
    /// not bounded.
    ///
    /// # Errors
    /// [`DataError::Cell`] for the first such row.
    pub fn check_travel(&self, path: &Path, length_m: f64) -> Result<(), DataError> {
        if self.actuation == Actuation::Tensions {
            return Ok(());
        }
        for (row, command) in self.commands.iter().enumerate() {
            let Some(tendon) = command.iter().position(|pull| pull.abs() > 2.0 * length_m) else { continue };
            let expected = format!("metres that a robot of {length_m} m could be pulled by (are these millimetres?)");
            let column = self.actuation.column(tendon);
            return Err(cell_error(path, row, &column, command[tendon].to_string(), expected));
        }
        Ok(())
    }

    /// Refuses recordings that are too long in total, or whose steps are: usually milliseconds instead of seconds.
    ///
    /// # Errors
    /// [`DataError::Cell`] for the last row of the trial that exceeds the limit, or after the first step that is too
    /// long.
    pub fn check_duration(&self, path: &Path) -> Result<(), DataError> {
        let mut all_s = 0.0;
        for (_, range) in self.trials() {
            let last = range.end - 1;
            all_s += self.time_s[last] - self.time_s[range.start];
            if all_s > LONGEST_S {
                let expected = format!("seconds, {LONGEST_S} of them in all trials at most (are these milliseconds?)");
                return Err(cell_error(path, last, "time_s", self.time_s[last].to_string(), expected));
            }
        }
        let within = self.trials().into_iter().flat_map(|(_, range)| range.skip(1));
        let steps: Vec<(usize, f64)> = within.map(|row| (row, self.time_s[row] - self.time_s[row - 1])).collect();
        let long = steps.iter().filter(|(_, step_s)| *step_s > LONGEST_STEP_S);
        match long.clone().next() {
            Some(&(row, step_s)) if 2 * long.count() > steps.len() => {
                let expected = format!("seconds, not {step_s} from one row to the next (are these milliseconds?)");
                Err(cell_error(path, row, "time_s", self.time_s[row].to_string(), expected))
            }
            _ => Ok(()),
        }
    }

    /// Refuses a payload that changes within a trial, since every trial starts at rest under it.
    ///
    /// # Errors
    /// [`DataError::Cell`] for the first row whose payload differs from the trial's first.
    pub fn check_loads(&self, path: &Path) -> Result<(), DataError> {
        let Some(hung) = &self.known_load_kg else { return Ok(()) };
        for (_, range) in self.trials() {
            let first = hung[range.start];
            if let Some(row) = range.clone().find(|&row| hung[row] != first) {
                let expected = format!("{first} as at the trial's start: the same weight to its end");
                return Err(cell_error(path, row, "known_load_kg", hung[row].to_string(), expected));
            }
        }
        Ok(())
    }
}
