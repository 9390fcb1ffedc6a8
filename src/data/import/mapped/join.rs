//! Joins commands and tracked bodies, of one log or of one log a trial, to a recording.

use std::path::{Path, PathBuf};

use super::clock_fit::{self, ClockFit};
use super::commands::{TRIAL_NAME, TimedCommands};
use super::map::{ClockMap, FrameChoice, TrackingMap};
use super::time::NS;
use super::tip_motion::CommandSteps;
use super::tracking::MappedBodies;
use super::{MappedImport, RepeatedRows, TrialClock};
use crate::base::Point3;
use crate::data::import::{Body, Export};
use crate::data::import::{
    ImportOptions, ImportedBodies, Log, TipFrame, check_overlap, import, log, resample,
};
use crate::data::recording::Extra;
use crate::data::{DataError, Recording};

/// Commands and bodies of one log, each with its file.
pub(super) struct JoinedLog {
    pub(super) file: PathBuf,
    pub(super) commands: TimedCommands,
    /// File of the bodies.
    pub(super) tracking_file: PathBuf,
    pub(super) bodies: MappedBodies,
}

/// A log on one clock: the time of each command on that of the bodies, seconds.
struct PlacedLog {
    log: JoinedLog,
    at_s: Vec<f64>,
}

/// Commands without tracking. `names`: of the trials, where the logs are trials with names.
pub(super) fn without_tracking(
    parts: Vec<(PathBuf, TimedCommands)>,
    names: Option<&[String]>,
) -> Result<MappedImport, DataError> {
    let repeated = RepeatedRows {
        commands: parts.iter().map(|(_, commands)| commands.repeated).sum(),
        poses: 0,
    };
    let at_rest = parts.iter().all(|(_, commands)| commands.at_rest);
    let (files, recordings): (Vec<PathBuf>, Vec<Recording>) =
        parts.into_iter().map(|(file, commands)| (file, commands.recording)).unzip();
    let recording = joined_commands(&files, &recordings, names)?;
    Ok(MappedImport {
        recording,
        imported: None,
        clocks: Vec::new(),
        passed_over: Vec::new(),
        repeated,
        at_rest,
    })
}

/// What sets clocks right.
const CLOCK_HINT: &str = " (`tracking.clock` of the map relates the clocks: `{first_row_after_s: \
                          0}` if both begin together; for messages of a bag use `time: {column: \
                          log_time}`)";

/// Joins the logs. `same_rows`: row by row, whatever the times.
pub(super) fn join(
    logs: Vec<JoinedLog>,
    map: &TrackingMap,
    same_rows: bool,
    names: Option<&[String]>,
) -> Result<MappedImport, DataError> {
    let several = logs.len() > 1;
    let repeated = RepeatedRows {
        commands: logs.iter().map(|log| log.commands.repeated).sum(),
        poses: logs.iter().map(|log| log.bodies.repeated).sum(),
    };
    let at_rest = logs.iter().all(|log| log.commands.at_rest);
    let mut clocks = Vec::new();
    let mut placed = Vec::new();
    let max_gap_s = if same_rows { 0.0 } else { map.max_gap_s };
    for mut log in logs {
        let at_s = if same_rows {
            let at_s = end_to_end(&log.commands.recording);
            log.bodies.time_s.clone_from(&at_s);
            at_s
        } else {
            let (at_s, fit) = on_one_clock(&log, &map.clock)?;
            let trial = several.then(|| log.commands.recording.trial[0]);
            clocks.extend(fit.map(|fit| TrialClock { trial, fit }));
            at_s
        };
        check_overlap(&log.bodies.time_s, &log.file, &at_s, CLOCK_HINT)?;
        placed.push(PlacedLog { log, at_s });
    }
    let (log, bodies, tracking_file) = one_after_another(placed, max_gap_s, names)?;
    // The check of the map has read the axes.
    let axes =
        map.to_axes().map_err(|(_, error)| fault(&tracking_file, error.found, error.expected))?;
    let frame = if map.frame == FrameChoice::Base { TipFrame::Base } else { TipFrame::Tracking };
    let options =
        ImportOptions { axes, frame, max_gap_s, gap_key: "`tracking.max_gap_s` of the map" };
    let export = Export::of_times(tracking_file, bodies.time_s);
    let points = bodies.points.iter().map(|(name, body)| (name.clone(), body)).collect();
    let parts = ImportedBodies { base: &bodies.base, tip: &bodies.tip, points };
    let mut imported = import(&export, &parts, &log, &options)?;
    if same_rows || several {
        // These times are nobody's.
        imported.recording.extra.retain(|(name, _)| name != log::EXPORT_TIME);
    }
    if same_rows {
        imported.doubts.onset_s = None;
        imported.doubts.jumps_m = None;
    }
    let recording = imported.recording.clone();
    Ok(MappedImport {
        recording,
        imported: Some(imported),
        clocks,
        passed_over: Vec::new(),
        repeated,
        at_rest,
    })
}

/// Time of each command on the clock of the bodies, and the offset where it is estimated.
fn on_one_clock(
    log: &JoinedLog,
    clock: &ClockMap,
) -> Result<(Vec<f64>, Option<ClockFit>), DataError> {
    let JoinedLog {
        file,
        commands: TimedCommands { recording, stamps_ns, is_zoned, .. },
        tracking_file,
        bodies,
    } = log;
    check_one_clock(file, recording, stamps_ns)?;
    let since = |from_ns: i64| {
        stamps_ns.iter().map(move |stamp| (stamp - from_ns) as f64 / NS).collect::<Vec<f64>>()
    };
    let mut estimate = None;
    let offset_s = match clock {
        ClockMap::Same => {
            check_zones(file, *is_zoned, tracking_file, bodies.is_zoned)?;
            0.0
        }
        ClockMap::OffsetS(offset_s) => *offset_s,
        ClockMap::FirstRowAfterS(after_s) => {
            let since_first_s = since(stamps_ns[0]).into_iter().map(|at_s| at_s - after_s);
            return Ok((since_first_s.collect(), None));
        }
        ClockMap::Estimate(range) => {
            // From the first stamp of each clock, so that their different origins take no digits.
            let origin_s = (stamps_ns[0] - bodies.first_ns) as f64 / NS;
            let [from_s, to_s] =
                [range.from_s, range.to_s].map(|limit_s| limit_s.map(|s| s - origin_s));
            let steps = CommandSteps { time_s: since(stamps_ns[0]), rows: command_rows(recording) };
            let fit = clock_fit::estimate(&steps, tips_from_base(bodies), from_s, to_s)
                .map_err(|(found, expected)| fault(tracking_file, found, &expected))?;
            let fit = fit.shifted(origin_s).with_dead_time(range.dead_time_s);
            estimate = Some(fit);
            fit.offset_s
        }
    };
    Ok((since(bodies.first_ns).into_iter().map(|at_s| at_s - offset_s).collect(), estimate))
}

/// Puts logs one after another in time, so far apart that nothing is interpolated between them.
fn one_after_another(
    placed: Vec<PlacedLog>,
    max_gap_s: f64,
    names: Option<&[String]>,
) -> Result<(Log, MappedBodies, PathBuf), DataError> {
    let several = placed.len() > 1;
    let mut recordings = Vec::new();
    let mut files = Vec::new();
    let mut all_at_s = Vec::new();
    let mut joined_bodies: Option<(MappedBodies, PathBuf)> = None;
    let mut end_s = 0.0;
    for PlacedLog { log: JoinedLog { file, commands, tracking_file, mut bodies }, at_s } in placed {
        let mut shift_s = 0.0;
        if several {
            let begin_s = at_s[0].min(bodies.time_s.first().copied().unwrap_or(at_s[0]));
            shift_s = end_s - begin_s;
            bodies.time_s.iter_mut().for_each(|time_s| *time_s += shift_s);
        }
        all_at_s.extend(at_s.iter().map(|time_s| time_s + shift_s));
        let last_s =
            all_at_s.last().into_iter().chain(bodies.time_s.last()).copied().fold(end_s, f64::max);
        end_s = last_s + max_gap_s + 1.0;
        recordings.push(commands.recording);
        files.push(file);
        match &mut joined_bodies {
            None => joined_bodies = Some((bodies, tracking_file)),
            Some((joined_bodies, _)) => append(joined_bodies, bodies),
        }
    }
    let Some((bodies, tracking_file)) = joined_bodies else {
        return Err(fault(Path::new(""), "no logs".to_owned(), "at least one"));
    };
    let commands = joined_commands(&files, &recordings, names)?;
    Ok((Log { file: files.swap_remove(0), commands, at_s: all_at_s }, bodies, tracking_file))
}

/// Appends the poses of the same bodies at later times.
fn append(all: &mut MappedBodies, later: MappedBodies) {
    all.time_s.extend(later.time_s);
    let join = |all: &mut Body, later: Body| all.poses.extend(later.poses);
    join(&mut all.base, later.base);
    join(&mut all.tip, later.tip);
    all.points.iter_mut().zip(later.points).for_each(|((_, all), (_, later))| join(all, later));
}

/// The recordings as one, with the names of the trials where they have names.
fn joined_commands(
    files: &[PathBuf],
    parts: &[Recording],
    names: Option<&[String]>,
) -> Result<Recording, DataError> {
    let extra = parts.first().map(|part| part.extra.clone()).unwrap_or_default();
    let mut joined = Recording::joined(parts).map_err(|error| {
        let text = error.to_string();
        let found = text.strip_prefix("found ").unwrap_or(&text).to_owned();
        fault(&files[error.index], found, "the same commands in all files")
    })?;
    if parts.len() == 1 {
        joined.extra = extra;
    }
    if let Some(names) = names {
        let rows = parts
            .iter()
            .zip(names)
            .flat_map(|(part, name)| std::iter::repeat_n(name.clone(), part.len()));
        joined.extra.push((TRIAL_NAME.to_owned(), Extra::Text(rows.collect())));
    }
    Ok(joined)
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
    let Some(row) = (1..stamps_ns.len()).find(|&row| stamps_ns[row] <= stamps_ns[row - 1]) else {
        return Ok(());
    };
    let found = format!("times that decrease at the start of trial {}", recording.trial[row]);
    Err(fault(file, found, "one clock for all trials, because the tracking has its own times"))
}

/// Refuses dates of one clock of which only one has a zone.
fn check_zones(
    file: &Path,
    is_zoned: Option<bool>,
    tracking_file: &Path,
    tracking_is_zoned: Option<bool>,
) -> Result<(), DataError> {
    let lacking = match (is_zoned, tracking_is_zoned) {
        (Some(false), Some(true)) => file,
        (Some(true), Some(false)) => tracking_file,
        _ => return Ok(()),
    };
    let found = "dates without a time zone, while the other times have one".to_owned();
    Err(fault(
        lacking,
        found,
        "`zone` in addition to `unit: iso8601` in the map, or `tracking.clock`",
    ))
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
    const MAX_BASE_GAP_S: f64 = 1.0;
    let tips = bodies.time_s.iter().zip(&bodies.tip.poses);
    let tracked = tips.filter_map(|(&time_s, pose)| {
        let tip = (*pose)?;
        let base = resample::pose_at(&bodies.time_s, &bodies.base.poses, time_s, MAX_BASE_GAP_S)?;
        let away_m = nalgebra::Vector3::from(tip.position_m) - base.translation.vector;
        let along_base_m =
            if bodies.base.has_orientation { base.rotation.inverse() * away_m } else { away_m };
        Some((time_s, along_base_m.into()))
    });
    tracked.collect()
}
