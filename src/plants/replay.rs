//! A recording as a plant: what a robot did when it was told the same, for trying out everything
//! that reads a plant.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::PlantOptions;
use crate::base::{BadOption, Observation, Plant, PlantError, Seed, SeenPoint, TendonCommand};
use crate::data::recording::PointTrack;
use crate::data::{Actuation, DataError, Recording};
use crate::effects::{DriveGains, TendonDrive, check_drives, drive_gains};
use crate::math::summary::quantile;

/// Which recording is replayed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReplayOptions {
    /// The recording, driven by lengths. Its path is relative to the folder of the plant file; in
    /// an experiment, to the working directory.
    pub recording: PathBuf,
    /// Permitted difference between a command and the recorded one, metres.
    #[serde(default = "tolerance_m")]
    pub tolerance_m: f64,
    /// Number of tendons of the robot.
    #[serde(default = "tendons")]
    pub tendons: usize,
    /// Drives of the recording's commands, as in a model.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub drives: BTreeMap<String, TendonDrive>,
}

fn tolerance_m() -> f64 {
    1e-6
}

fn tendons() -> usize {
    4
}

impl PlantOptions for ReplayOptions {
    fn check(&self) -> Result<(), (String, BadOption)> {
        let at = |error| (String::new(), error);
        BadOption::unless_positive("tolerance_m", self.tolerance_m).map_err(at)?;
        BadOption::unless_counted("tendons", self.tendons).map_err(at)?;
        check_drives(&self.drives, self.tendons)
    }

    fn tendons(&self) -> usize {
        self.tendons
    }

    fn drive_gains(&self) -> BTreeMap<String, DriveGains> {
        drive_gains(&self.drives)
    }

    fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String> {
        Ok(Box::new(Replay::open(self, step_s).map_err(|error| error.to_string())?))
    }

    /// The content of the recording, wherever it lies. One that cannot be read fails the stages
    /// that ask for it.
    fn identity(&self) -> Vec<u8> {
        std::fs::read(&self.recording).unwrap_or_default()
    }

    fn resolve_files(&mut self, folder: &Path) {
        self.recording = folder.join(&self.recording);
    }
}

/// A recording as a [`Plant`]: each reset begins its next trial (after the last one the first
/// again), each step gives the next row if it was commanded the same.
pub struct Replay {
    recording: Recording,
    tolerance_m: f64,
    trials: Vec<Range<usize>>,
    /// The next trial, the present row and the last row of the present trial.
    next: usize,
    row: usize,
    end: usize,
}

impl Replay {
    /// Reads the recording, whose rows are `step_s` seconds apart.
    ///
    /// # Errors
    /// [`DataError`] where it is none, is driven by tensions, or has another number of tendons or
    /// other steps.
    pub fn open(options: &ReplayOptions, step_s: f64) -> Result<Replay, DataError> {
        let mut recording = Recording::read(&options.recording)?;
        recording.convert_drives(
            &options.recording,
            &drive_gains(&options.drives),
            options.tendons,
        )?;
        if recording.actuation != Actuation::Lengths || recording.tendons() != options.tendons {
            let driven = if recording.actuation == Actuation::Lengths {
                "displacements"
            } else {
                "tensions"
            };
            return Err(DataError::Column {
                file: options.recording.clone(),
                place: "line 1",
                column: recording.actuation.column(0),
                found: format!("the {driven} of {} tendons", recording.tendons()),
                expected: format!("the displacements of {} tendons (tendon_1_m…)", options.tendons),
            });
        }
        same_steps(options, &recording, step_s)?;
        let trials = recording.trials().into_iter().map(|(_, rows)| rows).collect();
        Ok(Replay { recording, tolerance_m: options.tolerance_m, trials, next: 0, row: 0, end: 0 })
    }

    fn observation(&self) -> Observation {
        let row = self.row;
        let tip_m = self.recording.tip_m.as_ref().map_or([f64::NAN; 3], |tips| tips[row]);
        let seen_point = |point: &PointTrack| SeenPoint {
            position_m: point.position_m[row],
            quaternion: point.quaternion.as_ref().map(|all| all[row]),
        };
        let pulls_m = match row.checked_sub(1).filter(|_| self.recording.time_s[row] > 0.0) {
            Some(before) => self.recording.commands.row(before).to_vec(),
            None => vec![0.0; self.tendons()],
        };
        Observation {
            time_s: self.recording.time_s[row],
            tip_m,
            tip_quaternion: self.recording.tip_quaternion.as_ref().map(|all| all[row]),
            points: self.recording.points.iter().map(seen_point).collect(),
            pulls_m,
            tensions_n: None,
            valid: self.recording.is_valid(row),
        }
    }
}

/// The usual step may differ by this share: clocks and trackers jitter, and a tick whose pose was
/// lost is longer.
const STEP_TOLERANCE_SHARE: f64 = 0.05;

/// What was measured after another time is not what would be now.
fn same_steps(
    options: &ReplayOptions,
    recording: &Recording,
    step_s: f64,
) -> Result<(), DataError> {
    let step = |row: usize| recording.time_s[row] - recording.time_s[row - 1];
    let steps_s: Vec<f64> = recording
        .trials()
        .into_iter()
        .flat_map(|(_, rows)| (rows.start + 1..rows.end).map(step))
        .collect();
    let usual_s = quantile(&steps_s, 0.5);
    if (usual_s - step_s).abs() <= STEP_TOLERANCE_SHARE * step_s || steps_s.is_empty() {
        return Ok(());
    }
    Err(DataError::Cell {
        file: options.recording.clone(),
        place: "all rows".to_owned(),
        column: "time_s".to_owned(),
        found: format!("steps of {usual_s:.6} s"),
        expected: format!("{step_s} s, as the commands have"),
    })
}

impl Plant for Replay {
    fn tendons(&self) -> usize {
        self.recording.tendons()
    }

    fn points(&self) -> Vec<String> {
        self.recording.points.iter().map(|point| point.name.clone()).collect()
    }

    fn step_s(&self) -> f64 {
        let next = self.row + usize::from(self.row + 1 < self.end);
        let before = if next == self.row { self.row.saturating_sub(1) } else { self.row };
        self.recording.time_s[next.max(before)] - self.recording.time_s[before]
    }

    fn reset(&mut self, _seed: Seed) -> Result<Observation, PlantError> {
        let trial = self.trials[self.next % self.trials.len()].clone();
        self.next += 1;
        (self.row, self.end) = (trial.start, trial.end);
        Ok(self.observation())
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        if commands.len() != self.tendons() {
            return Err(PlantError::Refused(format!(
                "{} tendons, expected {}",
                commands.len(),
                self.tendons()
            )));
        }
        let (line, recorded) = (self.row + 2, self.recording.commands.row(self.row));
        for (tendon, (command, recorded_m)) in commands.iter().zip(recorded).enumerate() {
            let TendonCommand::Pull(pull_m) = *command else { continue };
            if !pull_m.is_finite() {
                return Err(PlantError::Refused("a displacement that is not finite".into()));
            }
            if (pull_m - recorded_m).abs() > self.tolerance_m {
                let message =
                    format!("tendon {} at {pull_m} m; line {line} has {recorded_m} m", tendon + 1);
                return Err(PlantError::NotRecorded(message));
            }
        }
        if self.row + 1 >= self.end {
            return Err(PlantError::NotRecorded(format!(
                "a step after the last row of the trial (line {line})"
            )));
        }
        self.row += 1;
        Ok(self.observation())
    }
}
