//! The shape of a simulated robot along a recording.

use std::path::Path;

use super::simulate_recording::simulate_recording;
use crate::base::Point3;
use crate::data::{DataError, Recording};
use crate::effects::{BodyPoint, Model};
use crate::tasks::{SimulationOptions, of_tendons};

/// Points of the line.
const LINE_POINTS: usize = 41;

/// Points from base to tip, metres, of the robot that `model` has under the commands of each row of
/// `recording`; none in rows that could not be solved. `file` is what the recording was read from.
///
/// # Errors
/// [`DataError`] for commands that are not those of the model's tendons or drives.
pub fn body_lines_m(
    file: &Path,
    recording: &Recording,
    model: &Model,
    at_rest: bool,
) -> Result<Vec<Vec<Point3>>, DataError> {
    let mut model = model.clone();
    let mut commands = recording.clone();
    of_tendons(&mut commands, file, &model.drive_gains(), model.robot.tendons.angles_deg.len())?;
    let length_m = model.robot.backbone.length_m;
    // Points that the simulation tracks; their names sort in the order of their places.
    let place = |k: usize| {
        let s_m = length_m * k as f64 / (LINE_POINTS - 1) as f64;
        (format!("line_{k:03}"), BodyPoint { s_m, offset_m: [0.0; 3] })
    };
    model.tracking.points = (0..LINE_POINTS).map(place).collect();
    let options = SimulationOptions { at_rest, ..SimulationOptions::default() };
    let simulated = simulate_recording(&model, &commands, &options);
    let of_row = |row: usize| {
        let points: Vec<Point3> =
            simulated.points.iter().map(|point| point.position_m[row]).collect();
        let solved = points.iter().flatten().all(|x| x.is_finite());
        if solved { points } else { Vec::new() }
    };
    Ok((0..recording.len()).map(of_row).collect())
}
