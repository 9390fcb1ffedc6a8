//! Import by a map: text files of any logger and topics of bags, with columns, units, axes, rates and clocks as the map
//! says. The rows are those of the commands; poses are interpolated at their times.

mod bag;
mod cdr;
mod check;
mod clock_fit;
mod columns;
mod commands;
mod delimited;
mod fit_sums;
mod map;
mod step_response;
mod tip_motion;
mod tracking;
mod units;

use std::path::{Path, PathBuf};

pub use bag::import_bag;
pub use check::SourceKind;
pub use clock_fit::ClockFit;
pub use columns::ColumnName;
pub use map::{
    BodyMap, ClockMap, CommandsMap, DriveMap, FrameChoice, ImportMap, LoadColumn, OffsetRange, QuaternionOrder,
    TendonMeasure, TendonsMap, TextFormat, TimeColumn, TrackingMap, ZeroAt,
};
pub use units::{CommandUnit, LengthUnit, MassUnit, TimeUnit};

use super::motive::Export;
use super::{ImportOptions, Imported, ImportedBodies, Log, TipFrame, import, log, resample};
use crate::base::Point3;
use crate::data::{DataError, Recording};
use commands::{NS, TimedCommands};
use tip_motion::CommandSteps;
use tracking::MappedBodies;

/// What an import by a map gives.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedImport {
    /// The recording.
    pub recording: Recording,
    /// What was joined, where the map has tracking; its recording is the one above.
    pub imported: Option<Imported>,
    /// The offset of the clocks, where it was estimated.
    pub clock: Option<ClockFit>,
}

/// Imports text files by a checked map ([`ImportMap::check`]).
///
/// # Errors
/// [`DataError`] names file, line, column, what was found and what was expected.
pub fn import_text(files: &[PathBuf], map: &ImportMap) -> Result<MappedImport, DataError> {
    let kind = SourceKind::Text(files.len());
    let file = &files[map.commands.file - 1];
    let format = map.commands.text.as_ref().unwrap_or(&map.text);
    let table = delimited::read(file, format)?;
    let commands = commands::read(&table, &map.commands)?;
    let Some(tracking) = &map.tracking else { return Ok(alone(commands)) };
    let own_file = &files[tracking.file_of(kind) - 1];
    let own_format = tracking.text.as_ref().unwrap_or(&map.text);
    let own = if own_file == file && own_format == format { table } else { delimited::read(own_file, own_format)? };
    let bodies = tracking::read(tracking, &|_| Ok(own.clone()))?;
    join((file, commands), (own_file, bodies), tracking, tracking.time.is_none())
}

/// Commands without tracking.
fn alone(commands: TimedCommands) -> MappedImport {
    MappedImport { recording: commands.recording, imported: None, clock: None }
}

/// Joins commands and bodies, each with its file. `same_rows`: row by row, whatever the times.
fn join(
    (file, commands): (&Path, TimedCommands),
    (own_file, mut bodies): (&Path, MappedBodies),
    map: &map::TrackingMap,
    same_rows: bool,
) -> Result<MappedImport, DataError> {
    // The check of the map has read the axes.
    let axes = map.to_axes().map_err(|(_, error)| fault(own_file, error.found, error.expected))?;
    let TimedCommands { recording, stamps_ns } = commands;
    let mut clock = None;
    let (at_s, max_gap_s) = if same_rows {
        let at_s = end_to_end(&recording);
        bodies.time_s.clone_from(&at_s);
        (at_s, 0.0)
    } else {
        check_one_clock(file, &recording, &stamps_ns)?;
        let since =
            |from_ns: i64| stamps_ns.iter().map(move |stamp| (stamp - from_ns) as f64 / NS).collect::<Vec<f64>>();
        let offset_s = match &map.clock {
            map::ClockMap::Same => 0.0,
            map::ClockMap::OffsetS(offset_s) => *offset_s,
            map::ClockMap::Estimate(range) => {
                // From the first stamp of each clock, so that their different origins take no digits.
                let origin_s = (stamps_ns[0] - bodies.first_ns) as f64 / NS;
                let limits = (range.from_s.map(|s| s - origin_s), range.to_s.map(|s| s - origin_s));
                let steps = CommandSteps { time_s: since(stamps_ns[0]), rows: command_rows(&recording) };
                let fit = clock_fit::estimate(&steps, tips_from_base(&bodies), limits)
                    .map_err(|(found, expected)| fault(own_file, found, &expected))?;
                let ClockFit { offset_s, interval_95_s, .. } = fit;
                let shifted = ClockFit {
                    offset_s: offset_s + origin_s,
                    interval_95_s: interval_95_s.map(|limit_s| limit_s + origin_s),
                    ..fit
                };
                clock = Some(shifted);
                shifted.offset_s
            }
        };
        (since(bodies.first_ns).into_iter().map(|at_s| at_s - offset_s).collect(), map.max_gap_s)
    };
    let frame = if map.frame == FrameChoice::Base { TipFrame::Base } else { TipFrame::Tracking };
    let options = ImportOptions { axes, frame, max_gap_s, gap_key: "`tracking.max_gap_s` of the map" };
    let log = Log { file: file.to_owned(), commands: recording, at_s };
    let export = Export::of_times(own_file.to_owned(), bodies.time_s);
    let points = bodies.points.iter().map(|(name, body)| (name.clone(), body)).collect();
    let parts = ImportedBodies { base: &bodies.base, tip: &bodies.tip, points };
    let mut imported = import(&export, &parts, &log, &options)?;
    if same_rows {
        imported.recording.extra.retain(|(name, _)| name != log::EXPORT_TIME);
        imported.doubts.onset_s = None;
    }
    Ok(MappedImport { recording: imported.recording.clone(), imported: Some(imported), clock })
}

fn fault(file: &Path, found: String, expected: &str) -> DataError {
    let (file, place) = (file.to_owned(), "all rows".to_owned());
    DataError::Line { file, place, found, expected: expected.to_owned() }
}

/// Time of each row with the trials end to end.
fn end_to_end(recording: &Recording) -> Vec<f64> {
    let mut at_s = Vec::with_capacity(recording.len());
    let mut start_s = 0.0;
    for (_, rows) in recording.trials() {
        at_s.extend(recording.time_s[rows.clone()].iter().map(|time_s| start_s + time_s));
        start_s += recording.time_s[rows.end - 1] + 1.0;
    }
    at_s
}

/// Refuses times that begin again in each trial: no other clock can be joined with them.
fn check_one_clock(file: &Path, recording: &Recording, stamps_ns: &[i64]) -> Result<(), DataError> {
    let Some(row) = (1..stamps_ns.len()).find(|&row| stamps_ns[row] <= stamps_ns[row - 1]) else { return Ok(()) };
    let found = format!("times that go back where trial {} begins", recording.trial[row]);
    Err(fault(file, found, "one clock for all trials, as the tracking has times of its own"))
}

/// Commands of tendons or drives, row by row.
fn command_rows(recording: &Recording) -> Vec<Vec<f64>> {
    if recording.drives.is_empty() {
        return recording.commands.iter().map(<[f64]>::to_vec).collect();
    }
    (0..recording.len()).map(|row| recording.drive_displacements(row)).collect()
}

/// Times on the tracker's clock and tips relative to the base, where both were tracked.
fn tips_from_base(bodies: &MappedBodies) -> Vec<(f64, Point3)> {
    /// The base may be tracked in other frames than the tip.
    const NEAR_S: f64 = 1.0;
    let tips = bodies.time_s.iter().zip(&bodies.tip.poses);
    let seen = tips.filter_map(|(&time_s, pose)| {
        let tip = (*pose)?;
        let base = resample::at(&bodies.time_s, &bodies.base.poses, time_s, NEAR_S)?;
        let away_m = nalgebra::Vector3::from(tip.position_m) - base.translation.vector;
        let turned = if bodies.base.has_orientation { base.rotation.inverse() * away_m } else { away_m };
        Some((time_s, turned.into()))
    });
    seen.collect()
}
