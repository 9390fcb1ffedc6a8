//! What the commands for robots share: the plant, and a resumable recording, trial by trial.

use crate::cli::program::outputs::check_measured;
use crate::cli::{CommandError, CommandResult};
use spinebench::base::{Plant, PlantError, Seed};
use spinebench::data::Recording;
use spinebench::data::recording::DriveTrack;
use spinebench::plants::hardware::{Hardware, HardwareOptions, operator};
use spinebench::specs::{PlantSpec, read_plant};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The `hardware` plant of a plant file.
pub(crate) fn read_hardware_plant(file: &Path) -> Result<Box<HardwareOptions>, CommandError> {
    match read_plant(file).map_err(CommandError::bad_input)? {
        PlantSpec::Hardware(options) => Ok(options),
        other => {
            let (file, kind) = (file.display(), other.kind());
            Err(CommandError::BadInput(format!("{file}: expected `hardware`, found `{kind}`")))
        }
    }
}

/// The plant that is recorded.
pub(crate) enum RecordedPlant {
    /// A real robot, on which an operator can hang weights, or a rehearsal of one.
    Hardware(Box<Hardware>),
    /// Any other plant.
    Other(Box<dyn Plant>),
}

impl RecordedPlant {
    pub(crate) fn open(
        plant: &PlantSpec,
        step_s: f64,
        seed: Seed,
    ) -> Result<RecordedPlant, CommandError> {
        match plant {
            PlantSpec::Hardware(options) => RecordedPlant::open_hardware(options, step_s, seed),
            other => Ok(RecordedPlant::Other(other.build(step_s).map_err(CommandError::Failed)?)),
        }
    }

    pub(crate) fn open_hardware(
        options: &HardwareOptions,
        step_s: f64,
        seed: Seed,
    ) -> Result<RecordedPlant, CommandError> {
        let hardware = Hardware::open(options, step_s, seed).map_err(CommandError::Failed)?;
        Ok(RecordedPlant::Hardware(Box::new(hardware)))
    }

    fn plant(&mut self) -> &mut dyn Plant {
        match self {
            RecordedPlant::Hardware(hardware) => hardware.as_mut(),
            RecordedPlant::Other(plant) => plant.as_mut(),
        }
    }

    /// Hangs a weight on the tip, in place of whatever hangs there. A simulated robot takes it by
    /// itself.
    fn hang_weight(&mut self, trial: u64, load_kg: f64, assume_done: bool) -> CommandResult {
        let grams = load_kg * 1e3;
        let what = if load_kg > 0.0 {
            format!("trial {trial}: hang {grams:.1} g on the tip")
        } else {
            format!("trial {trial}: remove everything from the tip")
        };
        match self {
            RecordedPlant::Other(_) => operator::ask_operator(&what),
            RecordedPlant::Hardware(hardware) if hardware.rehearsal().is_some() || assume_done => {
                eprintln!("note: {what}");
                hardware.hang_weight(load_kg, None)
            }
            RecordedPlant::Hardware(hardware) => hardware.hang_weight(load_kg, Some(&what)),
        }
        .map_err(CommandError::Failed)
    }
}

/// Records a trial: plant, commands, their rows, seed.
pub(crate) type RecordTrial<'a> =
    &'a dyn Fn(&mut dyn Plant, &Recording, Range<usize>, Seed) -> Result<Recording, PlantError>;

/// A recording in progress. Finished trials are stored in a `.part` file, so that an interrupted
/// recording can be resumed.
pub(crate) struct RecordingSession<'a> {
    out: &'a Path,
    part: PathBuf,
    commands: &'a Recording,
    done: Option<Recording>,
    /// Do not ask the operator for weights.
    pub(crate) assume_done: bool,
}

impl<'a> RecordingSession<'a> {
    /// Opens the recording `out` of these `commands`, with the trials that an earlier run has left.
    /// Refuses a place that takes no recording before a robot moves.
    pub(crate) fn open(
        out: &'a Path,
        commands: &'a Recording,
    ) -> Result<RecordingSession<'a>, CommandError> {
        check_measured(out, commands)?;
        let extension = out
            .extension()
            .map_or("csv".into(), |extension| extension.to_string_lossy().into_owned());
        let part = out.with_extension(format!("part.{extension}"));
        let mut session = RecordingSession { out, part, commands, done: None, assume_done: false };
        if !session.part.exists() {
            return Ok(session);
        }
        let mut earlier = Recording::read(&session.part).map_err(CommandError::bad_input)?;
        if !session.begins_with(&earlier) {
            let part = session.part.display();
            refuse!(
                "{part}: found a recording of other commands, expected the first trials of these; \
                 remove it to start over"
            );
        }
        // A file with commands of drives holds none of tendons.
        earlier.commands = commands.commands.select(&(0..earlier.len()).collect::<Vec<_>>());
        let (done, all) = (earlier.trials().len(), commands.trials().len());
        eprintln!("note: {}: resuming after {done} of {all} trials", session.part.display());
        session.done = Some(earlier);
        Ok(session)
    }

    fn begins_with(&self, earlier: &Recording) -> bool {
        let (count, commands) = (earlier.len(), self.commands);
        let hung_kg = |recording: &Recording, row: usize| {
            recording.known_load_kg.as_ref().map_or(0.0, |load| load[row])
        };
        let columns = |recording: &Recording| {
            recording.drives.iter().map(DriveTrack::column).collect::<Vec<_>>()
        };
        count <= commands.len()
            && columns(earlier) == columns(commands)
            && earlier.trial == commands.trial[..count]
            && earlier.time_s == commands.time_s[..count]
            && (0..count).all(|row| {
                let same_command = match earlier.drives.is_empty() {
                    true => earlier.commands.row(row) == commands.commands.row(row),
                    false => earlier.drive_displacements(row) == commands.drive_displacements(row),
                };
                same_command && hung_kg(earlier, row) == hung_kg(commands, row)
            })
    }

    /// Records the missing trials, and writes and returns the whole recording.
    pub(crate) fn record_missing(
        mut self,
        robot: &mut RecordedPlant,
        seed: Seed,
        record: RecordTrial,
    ) -> Result<Recording, CommandError> {
        let (trials, recorded) =
            (self.commands.trials(), self.done.as_ref().map_or(0, Recording::len));
        // After an interruption it is unknown which weight is attached.
        let mut hung_kg = if recorded == 0 { Some(0.0) } else { None };
        for (number, rows) in trials.iter().filter(|(_, rows)| rows.start >= recorded) {
            if let Some(load_kg) = self.commands.known_load_kg.as_ref().map(|load| load[rows.start])
                && hung_kg != Some(load_kg)
            {
                robot.hang_weight(*number, load_kg, self.assume_done)?;
                hung_kg = Some(load_kg);
            }
            match record(robot.plant(), self.commands, rows.clone(), seed.index(*number)) {
                Ok(trial) => self.append_trial(trial)?,
                Err(error) => {
                    let (done, all) = (self.trials(), trials.len());
                    let advice = "run the same command to resume";
                    return Err(CommandError::Failed(format!(
                        "trial {number}: {error}; {done} of {all} trials are kept, {advice}"
                    )));
                }
            }
        }
        // Commands without a trial make a recording without one.
        let mut whole = self.done.take().unwrap_or_else(|| self.commands.clone());
        whole.extra.clone_from(&self.commands.extra);
        whole.write(self.out).map_err(CommandError::bad_input)?;
        if self.part.exists() {
            std::fs::remove_file(&self.part).map_err(|error| {
                CommandError::Failed(format!("{}: {error}", self.part.display()))
            })?;
        }
        Ok(whole)
    }

    fn trials(&self) -> usize {
        self.done.as_ref().map_or(0, |done| done.trials().len())
    }

    fn append_trial(&mut self, trial: Recording) -> CommandResult {
        let all = match self.done.take() {
            Some(done) => Recording::joined(&[done, trial]).map_err(CommandError::failed)?,
            None => trial,
        };
        self.done.insert(all).write(&self.part).map_err(CommandError::bad_input)
    }
}
