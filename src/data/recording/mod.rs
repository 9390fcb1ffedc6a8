//! The recording format: commands and measured tips, trial by trial. A CSV or Parquet table with
//! one row per control tick: `trial,time_s,tendon_1_m…,tip_x_m,tip_y_m,tip_z_m` and optional
//! columns; see `docs/reference/outputs.md`.

mod check;
mod columns;
mod drives;
pub mod exclusions;
mod extra;
mod join;
mod optional;
mod points;
mod read;
mod select;
mod shift;
mod write;

use std::ops::Range;

use super::{DataError, RecordingSource};
use crate::base::{Point3, Rows};
use read::{Expected, Times};

pub use drives::{DriveTrack, DriveUnit};
pub(crate) use extra::{cell_error, column_error};
pub use join::RecordingMismatch;
pub(super) use optional::unit_length;
pub use points::PointTrack;

/// Kind of the commands of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Actuation {
    /// Displacement of each tendon at the drive, metres, 0 at home, positive pulls (`tendon_1_m`…).
    Lengths,
    /// Tension of each tendon, newtons (`tendon_1_n`…).
    Tensions,
}

impl Actuation {
    /// Name of the column of tendon number `tendon`, counted from 0.
    pub fn column(self, tendon: usize) -> String {
        let unit = match self {
            Actuation::Lengths => "m",
            Actuation::Tensions => "n",
        };
        format!("tendon_{}_{unit}", tendon + 1)
    }
}

/// Pose of a tracked body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position, metres.
    pub position_m: Point3,
    /// Unit quaternion w, x, y, z: rotation from the body's axes to the observing frame.
    pub quaternion: [f64; 4],
}

/// A recorded load at the tip, world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RecordedWrench {
    /// Force, newtons (`tip_force_x_n…`).
    pub force_n: [f64; 3],
    /// Moment, newton metres (`tip_moment_x_nm…`).
    pub moment_nm: [f64; 3],
}

/// The cells of an unknown column, carried from file to file unchanged.
#[derive(Clone, Debug, PartialEq)]
pub enum Extra {
    /// Whole numbers.
    Integers(Vec<i64>),
    /// Numbers; not a number where the cell was empty.
    Numbers(Vec<f64>),
    /// Anything else, and every unknown column of a CSV; empty where the cell was empty.
    Text(Vec<String>),
}

impl Extra {
    /// Number of cells.
    pub fn len(&self) -> usize {
        match self {
            Extra::Integers(cells) => cells.len(),
            Extra::Numbers(cells) => cells.len(),
            Extra::Text(cells) => cells.len(),
        }
    }

    /// True when there is no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A checked recording. All columns have [`Recording::len`] rows; the rows of a trial stand
/// together.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Whether the commands are lengths or tensions.
    pub actuation: Actuation,
    /// Trial that the row belongs to.
    pub trial: Vec<u64>,
    /// Time since the trial began, seconds; starts at 0 and increases within a trial, unless rows
    /// are poses at rest.
    pub time_s: Vec<f64>,
    /// Commands, one row of one number a tendon, metres or newtons; in force from the row's time to
    /// the next row's. Empty after reading a file with commands of drives, until
    /// [`Recording::convert_drives`].
    pub commands: Rows,
    /// Commands of drives, in the order of their names, where the file has them in place of those
    /// of tendons.
    pub drives: Vec<DriveTrack>,
    /// Measured tip at the row's time, metres; none in a file of commands. Not a number where
    /// tracking was lost.
    pub tip_m: Option<Vec<Point3>>,
    /// Tip orientation, unit quaternion w, x, y, z (`tip_qw,tip_qx,tip_qy,tip_qz`).
    pub tip_quaternion: Option<Vec<[f64; 4]>>,
    /// Pose of the base markers (`base_x_m,base_y_m,base_z_m,base_qw…`).
    pub base: Option<Vec<Pose>>,
    /// Known payload at the tip, kilograms.
    pub known_load_kg: Option<Vec<f64>>,
    /// False where tracking was lost (`valid` is 0); such rows keep their command.
    pub valid: Option<Vec<bool>>,
    /// True where the row is a pose at rest under its own command, whatever the times say
    /// (`at_rest` is 1).
    pub at_rest: Option<Vec<bool>>,
    /// Load at the tip, applied from the row's time on.
    pub tip_load: Option<Vec<RecordedWrench>>,
    /// Gravity in the world frame, m/s², the same in all rows of a trial, where it is not that of
    /// the model.
    pub gravity_m_s2: Option<Vec<[f64; 3]>>,
    /// Further tracked points, in the order of their names.
    pub points: Vec<PointTrack>,
    /// What the row belongs to, such as a kind of motion: a label by which rows can be held out.
    pub pattern: Option<Vec<String>>,
    /// Columns beyond the format, in the order of the file.
    pub extra: Vec<(String, Extra)>,
}

impl Recording {
    /// A recording of commands without rows; the caller fills in `trial`, times and commands.
    pub fn new(actuation: Actuation, tendons: usize) -> Self {
        Recording {
            actuation,
            trial: Vec::new(),
            time_s: Vec::new(),
            commands: Rows::new(tendons),
            drives: Vec::new(),
            tip_m: None,
            tip_quaternion: None,
            base: None,
            known_load_kg: None,
            valid: None,
            at_rest: None,
            tip_load: None,
            gravity_m_s2: None,
            points: Vec::new(),
            pattern: None,
            extra: Vec::new(),
        }
    }

    /// Reads a recording, CSV or Parquet, and checks all of it; the tip or another tracked point
    /// must be there.
    ///
    /// # Errors
    /// [`DataError`] names file, line, column, what was found and what was expected.
    pub fn read<'a>(source: impl Into<RecordingSource<'a>>) -> Result<Recording, DataError> {
        read::recording(source.into(), &Expected { measured: true, times: Times::Increasing })
    }

    /// Reads a recording as it is marked: poses at rest where every row is (`at_rest`), as
    /// [`Recording::read`] otherwise.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_as_marked<'a>(
        source: impl Into<RecordingSource<'a>>,
    ) -> Result<Recording, DataError> {
        let times = Times::IncreasingUnlessAtRest;
        read::recording(source.into(), &Expected { measured: true, times })
    }

    /// Reads a recording of poses at rest: as [`Recording::read`], with any times, also repeated or
    /// decreasing ones.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_poses<'a>(source: impl Into<RecordingSource<'a>>) -> Result<Recording, DataError> {
        read::recording(source.into(), &Expected { measured: true, times: Times::Any })
    }

    /// Reads the commands of poses at rest: as [`Recording::read_commands`], with any times.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_pose_commands<'a>(
        source: impl Into<RecordingSource<'a>>,
    ) -> Result<Recording, DataError> {
        read::recording(source.into(), &Expected { measured: false, times: Times::Any })
    }

    /// Reads commands: a recording whose measured columns may be missing (and are kept when they
    /// are not).
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_commands<'a>(
        source: impl Into<RecordingSource<'a>>,
    ) -> Result<Recording, DataError> {
        read::recording(source.into(), &Expected { measured: false, times: Times::Increasing })
    }

    /// Number of rows that are marked as poses at rest.
    pub fn rows_at_rest(&self) -> usize {
        self.at_rest.iter().flatten().filter(|at_rest| **at_rest).count()
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.trial.len()
    }

    /// True when there is no row.
    pub fn is_empty(&self) -> bool {
        self.trial.is_empty()
    }

    /// Number of tendons.
    pub fn tendons(&self) -> usize {
        self.commands.width()
    }

    /// The trials in the order of the file: number and rows.
    pub fn trials(&self) -> Vec<(u64, Range<usize>)> {
        let mut trials: Vec<(u64, Range<usize>)> = Vec::new();
        for (row, &number) in self.trial.iter().enumerate() {
            match trials.last_mut() {
                Some((last, rows)) if *last == number => rows.end = row + 1,
                _ => trials.push((number, row..row + 1)),
            }
        }
        trials
    }

    /// Drops the orientations of the tip and of all points, as a tracker of single markers has it.
    pub fn forget_orientations(&mut self) {
        self.tip_quaternion = None;
        self.points.iter_mut().for_each(|point| point.quaternion = None);
    }

    /// Whether the tip was tracked in this row.
    pub fn is_valid(&self, row: usize) -> bool {
        self.valid.as_ref().is_none_or(|valid| valid[row])
    }
}
