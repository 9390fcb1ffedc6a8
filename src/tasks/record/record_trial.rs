//! Executes commands on any plant, trial by trial, and records the measurements of its tracker.

use std::ops::Range;

use crate::base::{Observation, Plant, PlantError, Rows, Seed, SeenPoint};
use crate::data::Recording;
use crate::data::recording::PointTrack;

/// Why commands cannot be executed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UnevenSteps {
    /// Steps differ in length; a plant moves in equal steps.
    #[error(
        "trial {trial}: found a step of {found_s} s, expected {expected_s} s, the step between the \
         first two rows"
    )]
    Uneven {
        /// The trial.
        trial: u64,
        /// A step that differs.
        found_s: f64,
        /// The first step of the file.
        expected_s: f64,
    },
    /// No trial has two rows.
    #[error("found no trial with two rows, expected commands with a duration")]
    None,
}

/// Tolerance of time steps, s: written times are rounded.
const STEP_TOLERANCE_S: f64 = 1e-6;

/// The common length of all steps of `commands`, s.
///
/// # Errors
/// [`UnevenSteps`] when they differ or there is none.
pub fn step_s(commands: &Recording) -> Result<f64, UnevenSteps> {
    let mut first_s = None;
    for (trial, rows) in commands.trials() {
        for pair in commands.time_s[rows].windows(2) {
            let found_s = pair[1] - pair[0];
            let expected_s = *first_s.get_or_insert(found_s);
            if (found_s - expected_s).abs() > STEP_TOLERANCE_S {
                return Err(UnevenSteps::Uneven { trial, found_s, expected_s });
            }
        }
    }
    first_s.ok_or(UnevenSteps::None)
}

/// Executes the `rows` of one trial from rest at home. Returns the measurements as a recording of
/// these rows.
///
/// # Errors
/// [`PlantError`] when the plant stops or refuses; the trial is lost.
pub fn record_trial(
    plant: &mut dyn Plant,
    commands: &Recording,
    rows: Range<usize>,
    seed: Seed,
) -> Result<Recording, PlantError> {
    let mut observations: Vec<Observation> = vec![plant.reset(seed)?];
    // A row is the state before its command, so the last command is not executed.
    for row in rows.start..rows.end - 1 {
        observations.push(plant.step(commands.commands.row(row))?);
    }
    plant.verify()?;
    Ok(measured_rows(commands, rows, &observations, &plant.points()))
}

/// The rows of `commands` with what was `seen`; `points` are the names of the tracked points.
pub(crate) fn measured_rows(
    commands: &Recording,
    rows: Range<usize>,
    seen: &[Observation],
    points: &[String],
) -> Recording {
    let mut trial_commands = Rows::new(commands.tendons());
    rows.clone().for_each(|row| trial_commands.push(commands.commands.row(row)));
    // A row without tracking has no orientation; the others keep theirs.
    let has_orientation = seen.iter().any(|seen| seen.tip_quaternion.is_some());
    let quaternion = has_orientation
        .then(|| seen.iter().map(|seen| seen.tip_quaternion.unwrap_or([f64::NAN; 4])).collect());
    let valid: Vec<bool> = seen.iter().map(|seen| seen.valid).collect();
    Recording {
        commands: trial_commands,
        drives: commands.drives.iter().map(|drive| drive.of_rows(rows.clone())).collect(),
        trial: commands.trial[rows.clone()].to_vec(),
        time_s: commands.time_s[rows.clone()].to_vec(),
        tip_m: Some(seen.iter().map(|seen| seen.tip_m).collect()),
        tip_quaternion: quaternion,
        known_load_kg: commands.known_load_kg.as_ref().map(|load| load[rows.clone()].to_vec()),
        gravity_m_s2: commands.gravity_m_s2.as_ref().map(|gravity| gravity[rows.clone()].to_vec()),
        pattern: commands.pattern.as_ref().map(|labels| labels[rows].to_vec()),
        points: point_tracks(points, &seen.iter().map(Some).collect::<Vec<_>>()),
        valid: valid.contains(&false).then_some(valid),
        ..Recording::new(commands.actuation, commands.tendons())
    }
}

/// The tracks of the points with these names; where nothing was `seen`, not a number. Without any
/// orientation there is no column of it.
pub(crate) fn point_tracks(names: &[String], seen: &[Option<&Observation>]) -> Vec<PointTrack> {
    let track = |(index, name): (usize, &String)| {
        let all = || seen.iter().map(|seen| seen.and_then(|seen| seen.points.get(index)));
        let has_orientation =
            all().any(|point| point.is_some_and(|point| point.quaternion.is_some()));
        let orientation = |point: Option<&SeenPoint>| {
            point.and_then(|point| point.quaternion).unwrap_or([f64::NAN; 4])
        };
        PointTrack {
            name: name.clone(),
            position_m: all()
                .map(|point| point.map_or([f64::NAN; 3], |point| point.position_m))
                .collect(),
            quaternion: has_orientation.then(|| all().map(orientation).collect()),
        }
    };
    names.iter().enumerate().map(track).collect()
}
