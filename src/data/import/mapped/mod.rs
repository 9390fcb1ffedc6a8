//! Import by a map: text files of any logger and topics of bags, with columns, units, axes, rates
//! and clocks as the map says. The rows are those of the commands; poses are interpolated at their
//! times.

mod bag;
mod cell_match;
mod check;
mod clock_fit;
mod columns;
mod commands;
mod delimited;
mod euler;
mod fit_sums;
mod iso8601;
mod join;
mod map;
mod ros_message;
mod step_response;
mod time;
mod tip_motion;
mod tracking;
mod trial_files;
mod units;

use std::path::{Path, PathBuf};

pub use bag::import_bag;
pub use cell_match::CellMatch;
pub use check::SourceKind;
pub use clock_fit::ClockFit;
pub use columns::ColumnName;
pub(crate) use columns::LogTable;
pub(super) use delimited::parse as parse_delimited;
pub use map::{
    BodyMap, ClockMap, CommandsMap, DriveMap, EulerMap, EulerOrder, EulerRotation, FrameChoice,
    FrameRate, ImportMap, LoadColumn, OffsetRange, QuaternionOrder, RepeatedStamps, RowConditions,
    TendonMeasure, TendonsMap, TextFormat, TimeMap, TimePart, TrackingMap, TrialFilesMap, ZeroAt,
};
pub use trial_files::LogFiles;
pub use units::{AngleUnit, CommandUnit, LengthUnit, MassUnit, TimeUnit};

use super::{Imported, SettingNames};
use crate::data::{DataError, Recording};
use commands::TimedCommands;
use join::{JoinedLog, join, without_tracking};
use tracking::MappedBodies;
use trial_files::FoundTrials;

/// What an import by a map gives.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedImport {
    /// The recording.
    pub recording: Recording,
    /// What was joined, where the map has tracking; its recording is the one above.
    pub imported: Option<Imported>,
    /// The offsets of clocks that were estimated.
    pub clocks: Vec<TrialClock>,
    /// Files whose names fit no pattern of the map.
    pub passed_over: Vec<PathBuf>,
    /// Rows that do not count.
    pub repeated: RepeatedRows,
    /// Whether the rows are poses at rest, as the map names no times.
    pub at_rest: bool,
}

/// What notes call the keys of a map.
const KEYS: SettingNames = SettingNames {
    axes: "`tracking.axes` ",
    bodies: "`tracking.base` and `tracking.tip`",
    base: "`tracking.base` or `tracking.origin`",
    home: "`commands.tendons.zero` or `home` of the map",
    clock: "add it to `tracking.clock.offset_s`",
    rows: "; `tracking.tip.where` selects those of the tip",
};

impl MappedImport {
    /// Sentences about files and rows that do not count, and about what looks like a mistake.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(first) = self.passed_over.first() {
            let (count, first) = (self.passed_over.len(), first.display());
            notes.push(format!(
                "the names of {count} files match no pattern of `trial_files` (first: {first}); \
                 these files were not read"
            ));
        }
        if self.at_rest {
            notes.push(format!(
                "the map defines no times: the {} rows are marked as poses at rest (`at_rest`)",
                self.recording.len()
            ));
        }
        let RepeatedRows { commands, poses } = self.repeated;
        if commands > 0 {
            notes.push(format!(
                "{commands} rows of commands have the same time as the next row; only the next row \
                 is used"
            ));
        }
        if poses > 0 {
            notes.push(format!(
                "{poses} tracked rows repeat the time and the pose of the previous row; the \
                 repetitions are ignored"
            ));
        }
        notes.extend(self.imported.iter().flat_map(|imported| imported.notes(&KEYS)));
        notes
    }
}

/// Rows that do not count because another has their time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RepeatedRows {
    /// Rows of commands that a later one has replaced.
    pub commands: usize,
    /// Tracked rows that repeat the pose of the row before.
    pub poses: usize,
}

/// An estimated offset of clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialClock {
    /// Number of the trial, where each trial has files of its own.
    pub trial: Option<u64>,
    /// The estimate.
    pub fit: ClockFit,
}

/// Imports text files by a checked map ([`ImportMap::check`]).
///
/// # Errors
/// [`DataError`] names file, line, column, what was found and what was expected.
pub fn import_text(files: &[PathBuf], map: &ImportMap) -> Result<MappedImport, DataError> {
    let Some(names) = &map.trial_files else {
        let file = &files[map.commands.file - 1];
        let tracking_file = map.tracking.as_ref().map(|tracking| {
            let source = SourceKind::Text { files: files.len(), from_folder: false };
            files[tracking.file_of(source) - 1].as_path()
        });
        let (commands, bodies) = read_log(file, tracking_file, map)?;
        let tracking_file = tracking_file.map(Path::to_owned);
        return joined(
            vec![ReadLog { file: file.clone(), tracking_file, commands, bodies }],
            map,
            None,
        );
    };
    let found_trials = FoundTrials::among(files, names)?;
    let mut logs = Vec::new();
    for trial in &found_trials.trials {
        let tracking_file = trial.tracking.as_ref().unwrap_or(&trial.commands);
        let (mut commands, bodies) =
            read_log(&trial.commands, map.tracking.is_some().then_some(tracking_file), map)?;
        commands.recording.trial.fill(trial.number);
        let (file, tracking_file) = (trial.commands.clone(), Some(tracking_file.clone()));
        logs.push(ReadLog { file, tracking_file, commands, bodies });
    }
    let names: Vec<String> = found_trials.trials.iter().map(|trial| trial.name.clone()).collect();
    let imported = joined(logs, map, found_trials.named.then_some(&names))?;
    Ok(MappedImport { passed_over: found_trials.passed_over, ..imported })
}

/// Files of a log, commands and bodies in them.
struct ReadLog {
    file: PathBuf,
    tracking_file: Option<PathBuf>,
    commands: TimedCommands,
    bodies: Option<MappedBodies>,
}

/// Reads the commands of a file and the bodies of another, or of the same.
fn read_log(
    file: &Path,
    tracking_file: Option<&Path>,
    map: &ImportMap,
) -> Result<(TimedCommands, Option<MappedBodies>), DataError> {
    let format = map.commands.text.as_ref().unwrap_or(&map.text);
    let table = delimited::read(file, format)?;
    let commands = commands::read(&table, &map.commands)?;
    let Some((tracking, tracking_file)) = map.tracking.as_ref().zip(tracking_file) else {
        return Ok((commands, None));
    };
    let tracking_format = tracking.text.as_ref().unwrap_or(&map.text);
    let tracking_table = if tracking_file == file && tracking_format == format {
        table
    } else {
        delimited::read(tracking_file, tracking_format)?
    };
    let bodies = tracking::read(tracking, &|_| Ok(tracking_table.clone()))?;
    Ok((commands, Some(bodies)))
}

/// Joins what was read.
fn joined(
    logs: Vec<ReadLog>,
    map: &ImportMap,
    names: Option<&Vec<String>>,
) -> Result<MappedImport, DataError> {
    let names = names.map(Vec::as_slice);
    let Some(tracking) = &map.tracking else {
        return without_tracking(
            logs.into_iter().map(|log| (log.file, log.commands)).collect(),
            names,
        );
    };
    let log = |ReadLog { file, tracking_file, commands, bodies }: ReadLog| {
        let tracking_file = tracking_file.unwrap_or_else(|| file.clone());
        bodies.map(|bodies| JoinedLog { file, commands, tracking_file, bodies })
    };
    join(logs.into_iter().filter_map(log).collect(), tracking, tracking.time.is_none(), names)
}
