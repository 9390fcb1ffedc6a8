//! Plausibility checks of recordings: units, durations, payloads.

use std::path::Path;

use super::extra::cell_error;
use super::{Actuation, Recording, read};
use crate::data::DataError;

/// Longest total duration of the trials, seconds: six hours.
const MAX_DURATION_S: f64 = 6.0 * 3600.0;
/// Longest plausible median step, seconds.
const MAX_MEDIAN_STEP_S: f64 = 60.0;

/// `path` is the file that the recording was read from.
impl Recording {
    /// Refuses tips and tracked points farther from the base at `base_m` than twice the length of
    /// the robot: usually millimetres instead of metres.
    ///
    /// # Errors
    /// [`DataError::Cell`] for the first such row.
    pub fn check_reach(
        &self,
        path: &Path,
        base_m: [f64; 3],
        length_m: f64,
    ) -> Result<(), DataError> {
        let points = self.points.iter().map(|point| (point.position_columns(), &point.position_m));
        let tip = self.tip_m.iter().map(|tips_m| (read::TIP.map(str::to_owned), tips_m));
        for (columns, positions_m) in tip.chain(points) {
            for (row, position_m) in
                positions_m.iter().enumerate().filter(|&(row, _)| self.is_valid(row))
            {
                let beyond_reach =
                    |&axis: &usize| (position_m[axis] - base_m[axis]).abs() > 2.0 * length_m;
                let Some(axis) = (0..3).find(beyond_reach) else { continue };
                let expected = format!(
                    "metres within reach of a robot of {length_m} m (are these millimetres?)"
                );
                return Err(cell_error(
                    path,
                    row,
                    &columns[axis],
                    position_m[axis].to_string(),
                    expected,
                ));
            }
        }
        Ok(())
    }

    /// Refuses displacements beyond twice the length of the robot: usually millimetres instead of
    /// metres. Tensions are not bounded.
    ///
    /// # Errors
    /// [`DataError::Cell`] for the first such row.
    pub fn check_travel(&self, path: &Path, length_m: f64) -> Result<(), DataError> {
        if self.actuation == Actuation::Tensions {
            return Ok(());
        }
        for (row, command) in self.commands.iter().enumerate() {
            let Some(tendon) = command.iter().position(|pull| pull.abs() > 2.0 * length_m) else {
                continue;
            };
            let expected = format!(
                "metres, a possible displacement for a robot of {length_m} m (are these \
                 millimetres?)"
            );
            let column = self.actuation.column(tendon);
            return Err(cell_error(path, row, &column, command[tendon].to_string(), expected));
        }
        Ok(())
    }

    /// Refuses recordings that are too long in total, or whose steps are: usually milliseconds
    /// instead of seconds.
    ///
    /// # Errors
    /// [`DataError::Cell`] for the last row of the trial that exceeds the limit, or after the first
    /// step that is too long.
    pub fn check_duration(&self, path: &Path) -> Result<(), DataError> {
        let mut total_s = 0.0;
        for (_, range) in self.trials() {
            let last = range.end - 1;
            total_s += self.time_s[last] - self.time_s[range.start];
            if total_s > MAX_DURATION_S {
                let expected = format!(
                    "seconds, at most {MAX_DURATION_S} in all trials together (are these \
                     milliseconds?)"
                );
                return Err(cell_error(
                    path,
                    last,
                    "time_s",
                    self.time_s[last].to_string(),
                    expected,
                ));
            }
        }
        let rows = self.trials().into_iter().flat_map(|(_, range)| range.skip(1));
        let steps: Vec<(usize, f64)> =
            rows.map(|row| (row, self.time_s[row] - self.time_s[row - 1])).collect();
        let long_steps = steps.iter().filter(|(_, step_s)| *step_s > MAX_MEDIAN_STEP_S);
        match long_steps.clone().next() {
            Some(&(row, step_s)) if 2 * long_steps.count() > steps.len() => {
                let expected = format!(
                    "seconds, with a step below the {step_s} between these rows (are these \
                     milliseconds?)"
                );
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
        let Some(loads_kg) = &self.known_load_kg else { return Ok(()) };
        for (_, range) in self.trials() {
            let first = loads_kg[range.start];
            if let Some(row) = range.clone().find(|&row| loads_kg[row] != first) {
                let expected = format!(
                    "{first}, as at the start of the trial: the weight is constant within a trial"
                );
                return Err(cell_error(
                    path,
                    row,
                    "known_load_kg",
                    loads_kg[row].to_string(),
                    expected,
                ));
            }
        }
        Ok(())
    }
}
