//! What is compared: the places of tracked points in rows of a recording, and what a model says of
//! them, in parallel.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

use crate::base::{InterruptRequest, Point3, counted};
use crate::calibration::error::CalibrationError;
use crate::calibration::recordings::Recordings;
use crate::data::Recording;
use crate::effects::{Model, Starts};
use crate::tasks::SimulationOptions;
use crate::tasks::simulate_recording;

/// Rows that one thread simulates one after the other when rows are independent. A fixed number, so
/// that the result does not depend on the number of threads.
const ROWS: usize = 48;

/// One measured position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sighting {
    /// Row of the recording.
    pub(crate) row: usize,
    /// Tracked point: 0 is the tip, then the recording's points.
    pub(crate) marker: usize,
    /// Measured, metres.
    pub(crate) at_m: Point3,
}

/// Recordings and what of them is compared.
#[derive(Clone, Debug)]
pub(crate) struct Comparison<'a> {
    pub(crate) recordings: &'a Recordings,
    pub(crate) at_rest: bool,
    pub(crate) sightings: Vec<Sighting>,
    /// Names of the tracked points.
    pub(crate) markers: Vec<String>,
    /// Whether the model remembers beyond its motion: by a moment law or an effect.
    pub(crate) remembers: bool,
    /// Whether rows do not depend on those before them.
    pub(crate) independent: bool,
    /// Whether trials go on from one another.
    continues: bool,
    /// The rows that a robot with memory visits, where these are not all.
    path: Option<Vec<usize>>,
    pub(crate) parts: Vec<Part>,
}

/// Rows that are simulated together.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) commands: Recording,
    /// Index of a sighting and its row in `commands`.
    pub(crate) sightings: Vec<(usize, usize)>,
}

/// Positions that a model says, one a sighting; none where it has no solution.
pub(crate) type Positions = Vec<Option<Point3>>;

impl<'a> Comparison<'a> {
    /// Every tracked point that `model` places, in every valid row.
    ///
    /// # Errors
    /// [`CalibrationError::NothingTracked`].
    pub(crate) fn new(
        model: &Model,
        recordings: &'a Recordings,
        at_rest: bool,
    ) -> Result<Comparison<'a>, CalibrationError> {
        let point_names = model.tracking.names();
        let recording = &recordings.joined;
        let mut tracks = tracks(recording);
        tracks.retain(|(name, _)| name == "tip" || point_names.contains(name));
        let mut sightings = Vec::new();
        for row in (0..recording.len()).filter(|&row| recording.is_valid(row)) {
            for (marker, (_, track)) in tracks.iter().enumerate() {
                let at_m = track.get(row).copied().unwrap_or([f64::NAN; 3]);
                if at_m.iter().all(|x| x.is_finite()) {
                    sightings.push(Sighting { row, marker, at_m });
                }
            }
        }
        if sightings.is_empty() {
            return Err(CalibrationError::NothingTracked);
        }
        let markers = tracks.into_iter().map(|(name, _)| name).collect();
        let comparison = Comparison {
            recordings,
            at_rest,
            sightings,
            markers,
            remembers: false,
            independent: true,
            continues: model.tracking.starts == Starts::Continue,
            path: None,
            parts: Vec::new(),
        };
        Ok(comparison.with_model(model))
    }

    /// The same with a model that may have more or less memory.
    pub(crate) fn with_model(self, model: &Model) -> Comparison<'a> {
        let remembers = model.remembers_at_rest();
        Comparison { remembers, independent: self.at_rest && !remembers, ..self }.divided()
    }

    /// Only some of the sightings, by index.
    pub(crate) fn only(&self, kept: &[usize]) -> Comparison<'a> {
        let sightings = kept.iter().map(|&index| self.sightings[index]).collect();
        Comparison { sightings, ..self.clone() }.divided()
    }

    /// Evenly chosen sightings, at most so many, and their indices. A robot at rest visits no other
    /// rows: a memory that does not depend on the rate goes much the same way through fewer poses.
    /// A motion goes through all rows.
    pub(crate) fn thinned(&self, wanted: usize) -> (Comparison<'a>, Vec<usize>) {
        let count = self.sightings.len();
        let wanted = count.min(wanted);
        let kept: Vec<usize> = (0..wanted).map(|k| k * count / wanted).collect();
        let rows = || kept.iter().map(|&index| self.sightings[index].row).collect();
        let path = self.at_rest.then(rows);
        (Comparison { path, ..self.clone() }.only(&kept), kept)
    }

    /// Number of compared rows.
    pub(crate) fn rows(&self) -> usize {
        let mut rows: Vec<usize> = self.sightings.iter().map(|sighting| sighting.row).collect();
        rows.dedup();
        rows.len()
    }

    /// Rows that are simulated together: poses at rest of a robot without memory in short parts,
    /// other trials up to the last compared row.
    fn divided(mut self) -> Self {
        self.parts = self.parts_of_trials();
        self
    }

    fn parts_of_trials(&self) -> Vec<Part> {
        let mut trials: Vec<Range<usize>> =
            self.recordings.joined.trials().into_iter().map(|(_, rows)| rows).collect();
        if self.continues && !self.independent {
            // Without new starts a whole recording is one motion.
            trials = self.recordings.each.iter().map(|(_, rows)| rows.clone()).collect();
        }
        let mut parts: Vec<Part> = Vec::new();
        for trial in trials {
            let of_trial = self
                .sightings
                .iter()
                .enumerate()
                .filter(|(_, sighting)| trial.contains(&sighting.row));
            let seen: Vec<(usize, usize)> =
                of_trial.map(|(index, sighting)| (index, sighting.row)).collect();
            let Some(&(_, last)) = seen.last() else { continue };
            if !self.independent {
                // A motion needs all commands before a compared row, and none after the last.
                let on_path = |row: &usize| {
                    self.path.as_ref().is_none_or(|path| path.binary_search(row).is_ok())
                };
                let rows: Vec<usize> = (trial.start..last + 1).filter(on_path).collect();
                parts.push(self.part(&rows, &seen));
                continue;
            }
            let mut rows: Vec<usize> = seen.iter().map(|&(_, row)| row).collect();
            rows.dedup();
            for chunk in rows.chunks(ROWS) {
                let range: Range<usize> = chunk[0]..chunk[chunk.len() - 1] + 1;
                let in_chunk: Vec<(usize, usize)> =
                    seen.iter().copied().filter(|(_, row)| range.contains(row)).collect();
                parts.push(self.part(chunk, &in_chunk));
            }
        }
        parts
    }

    fn part(&self, rows: &[usize], seen: &[(usize, usize)]) -> Part {
        let place = |row: usize| rows.binary_search(&row).unwrap_or_default();
        let measured = self.recordings.joined.rows(rows);
        let commands = Recording {
            tip_m: None,
            tip_quaternion: None,
            points: Vec::new(),
            extra: Vec::new(),
            ..measured
        };
        Part { commands, sightings: seen.iter().map(|&(index, row)| (index, place(row))).collect() }
    }

    pub(crate) fn options(&self) -> SimulationOptions {
        SimulationOptions { at_rest: self.at_rest, ..SimulationOptions::default() }
    }

    /// What of a part is simulated under `model`, and the model to do it with: its gains decide
    /// what the tendons do, and poses that do not depend on others need no home.
    pub(crate) fn driven<'b>(&self, part: &'b Part, model: &Model) -> (Model, Cow<'b, Recording>) {
        let mut model = model.clone();
        if self.independent {
            // A part may begin far from home, and nothing before it matters.
            model.tracking.starts = Starts::Anywhere;
        }
        let mut commands = Cow::Borrowed(&part.commands);
        if !part.commands.drives.is_empty() {
            let tendons = model.robot.tendons.angles_deg.len();
            // The recording has been converted before, so that no drive is missing.
            let _ = commands.to_mut().convert_drives(Path::new(""), &model.drive_gains(), tendons);
        }
        (model, commands)
    }

    pub(crate) fn simulated(&self, part: &Part, model: &Model) -> Recording {
        let (model, commands) = self.driven(part, model);
        simulate_recording(&model, &commands, &self.options())
    }

    /// What `model` says.
    pub(crate) fn positions(&self, model: &Model) -> Positions {
        let request = InterruptRequest::current();
        let simulated = |part| request.within(|| self.simulated(part, model));
        let each: Vec<Recording> = self.parts.par_iter().map(counted(simulated)).collect();
        let mut positions = vec![None; self.sightings.len()];
        for (part, simulated) in self.parts.iter().zip(&each) {
            self.take(part, &tracks(simulated), &mut positions);
        }
        positions
    }

    pub(crate) fn take(
        &self,
        part: &Part,
        tracks: &[(String, &[Point3])],
        positions: &mut [Option<Point3>],
    ) {
        for &(index, row) in &part.sightings {
            let name = &self.markers[self.sightings[index].marker];
            let track = tracks.iter().find(|(track_name, _)| track_name == name);
            positions[index] =
                track.map(|(_, track)| track[row]).filter(|at| at.iter().all(|x| x.is_finite()));
        }
    }
}

/// The tracked points of a recording, with their positions: the tip first.
pub(crate) fn tracks(recording: &Recording) -> Vec<(String, &[Point3])> {
    let tip = recording.tip_m.iter().map(|tip| ("tip".to_owned(), tip.as_slice()));
    tip.chain(
        recording.points.iter().map(|point| (point.name.clone(), point.position_m.as_slice())),
    )
    .collect()
}
