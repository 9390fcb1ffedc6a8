//! Import: joins a tracker's export and a command log to a recording of the tip, and of points
//! along the body, relative to the base.

mod axes;
mod export;
mod formats;
mod log;
pub mod mapped;
mod motive;
mod notes;
mod plausibility;
mod resample;
mod response;

pub use axes::{Axes, BadAxes};
pub use export::{Body, Export};
pub use formats::ExportFormat;
pub use log::Log;
pub use notes::SettingNames;
pub use plausibility::ImportDoubts;

use std::path::Path;

use nalgebra::Isometry3;

use crate::data::recording::{Extra, PointTrack, Pose};
use crate::data::{DataError, Recording};
use crate::math::rotation;
use resample::pose_at;

/// Axes of the tip position; its origin is the base body's pivot in both cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TipFrame {
    /// Axes of the base body, row by row: rotation of the tracking frame and motion of the stand
    /// cancel.
    Base,
    /// Axes of the tracker, whose up direction opposes gravity: a tilted base is visible at the
    /// tip.
    Tracking,
}

/// Options of an import.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportOptions {
    /// The project's axes in the tracker's.
    pub axes: Axes,
    /// Axes of the tip position.
    pub frame: TipFrame,
    /// Longest gap between tracked frames that is interpolated, seconds.
    pub max_gap_s: f64,
    /// What the user calls that gap.
    pub gap_key: &'static str,
}

/// Result of an import.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The log with the tip, its orientation, the base's pose and `valid`.
    pub recording: Recording,
    /// Rows without a tip.
    pub lost: usize,
    /// Mean angle between the axes of the base body and those of the tracker, radians.
    pub base_turn_rad: f64,
    /// What looks like a mistake.
    pub doubts: ImportDoubts,
}

/// What stands for which part of the robot.
#[derive(Clone, Debug)]
pub struct ImportedBodies<'a> {
    /// On the base.
    pub base: &'a Body,
    /// On the tip.
    pub tip: &'a Body,
    /// Along the body, each with its name in the recording.
    pub points: Vec<(String, &'a Body)>,
}

/// Joins the poses of `bodies` in `export` with the commands of `log`. Without an orientation of
/// the base the axes are the tracker's, whatever the options say.
///
/// # Errors
/// [`DataError`] when there is no row in which base and tip were tracked.
pub fn import(
    export: &Export,
    bodies: &ImportedBodies,
    log: &Log,
    options: &ImportOptions,
) -> Result<Imported, DataError> {
    let (base, tip) = (bodies.base, bodies.tip);
    let frame = if base.has_orientation { options.frame } else { TipFrame::Tracking };
    check_overlap(&export.time_s, &log.file, &log.at_s, "")?;
    let pose =
        |body: &Body, time_s| pose_at(&export.time_s, &body.poses, time_s, options.max_gap_s);
    let mut recording = log.commands.clone();
    let (mut tips, mut orientations, mut bases, mut valid) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut angles_rad = Vec::new();
    for (row, &time_s) in log.at_s.iter().enumerate() {
        let base = pose(base, time_s);
        let tip_pose = base.zip(pose(tip, time_s)).filter(|_| log.commands.is_valid(row));
        let tip_pose = tip_pose.map(|(base, tip)| from_base(&base, &tip, frame));
        angles_rad.extend(base.map(|base| base.rotation.angle()));
        let quaternion =
            |pose: Isometry3<f64>| rotation::parts(&options.axes.rotation(&pose.rotation));
        let place_m = |pose: Isometry3<f64>| options.axes.vector(&pose.translation.vector).into();
        tips.push(tip_pose.map_or([f64::NAN; 3], place_m));
        orientations.push(tip_pose.map_or([f64::NAN; 4], quaternion));
        bases.push(Pose {
            position_m: base.map_or([f64::NAN; 3], place_m),
            quaternion: base.map_or([f64::NAN; 4], quaternion),
        });
        valid.push(tip_pose.is_some());
    }
    let point = |name: &str, body: &Body| {
        let poses = log.at_s.iter().map(|&time_s| {
            let pose = from_base(&pose(base, time_s)?, &pose(body, time_s)?, frame);
            Some((
                options.axes.vector(&pose.translation.vector).into(),
                rotation::parts(&options.axes.rotation(&pose.rotation)),
            ))
        });
        let (position_m, orientations) =
            poses.map(|pose| pose.unwrap_or(([f64::NAN; 3], [f64::NAN; 4]))).unzip();
        PointTrack {
            name: name.to_owned(),
            position_m,
            quaternion: body.has_orientation.then_some(orientations),
        }
    };
    let lost = valid.iter().filter(|valid| !**valid).count();
    if lost == valid.len() {
        return Err(never_seen(export, options));
    }
    let base_turn_rad = angles_rad.iter().sum::<f64>() / angles_rad.len() as f64;
    recording.tip_m = Some(tips);
    recording.tip_quaternion = tip.has_orientation.then_some(orientations);
    recording.points = bodies.points.iter().map(|(name, body)| point(name, body)).collect();
    recording.points.sort_by(|a, b| a.name.cmp(&b.name));
    recording.valid = Some(valid);
    recording.extra.retain(|(name, _)| name != log::EXPORT_TIME);
    recording.extra.push((log::EXPORT_TIME.to_owned(), Extra::Numbers(log.at_s.clone())));
    let tip_at = |time_s: f64| {
        let pose = from_base(&pose(base, time_s)?, &pose(tip, time_s)?, frame);
        Some(options.axes.vector(&pose.translation.vector).into())
    };
    let onset_s = response::onset_s(log, &tip_at);
    let tip_world_m: Vec<_> = tip.poses.iter().flatten().map(|pose| pose.position_m).collect();
    let base_m: Vec<_> = bases.iter().map(|pose| pose.position_m).collect();
    recording.base = base.has_orientation.then_some(bases);
    let doubts = plausibility::doubts(&recording, &options.axes, &base_m, &tip_world_m, onset_s);
    Ok(Imported { recording, lost, base_turn_rad, doubts })
}

/// The tip relative to the base's pivot, in the requested axes (before renaming to the project's).
fn from_base(base: &Isometry3<f64>, tip: &Isometry3<f64>, frame: TipFrame) -> Isometry3<f64> {
    match frame {
        TipFrame::Base => base.inv_mul(tip),
        TipFrame::Tracking => {
            let away_m = tip.translation.vector - base.translation.vector;
            Isometry3::from_parts(away_m.into(), tip.rotation)
        }
    }
}

/// Refuses commands of which none is within the tracking. `hint`: what may mend it.
fn check_overlap(frames_s: &[f64], file: &Path, at_s: &[f64], hint: &str) -> Result<(), DataError> {
    let span = |times_s: &[f64]| {
        times_s.first().copied().zip(times_s.last().copied()).unwrap_or((f64::NAN, f64::NAN))
    };
    let ((first_s, last_s), (begin_s, end_s)) = (span(frames_s), span(at_s));
    if begin_s <= last_s && end_s >= first_s {
        return Ok(());
    }
    let found = format!("commands from {begin_s} s to {end_s} s in the export");
    let expected =
        format!("some within the export, which goes from {first_s} s to {last_s} s{hint}");
    Err(DataError::Line { file: file.to_owned(), place: "all rows".to_owned(), found, expected })
}

fn never_seen(export: &Export, options: &ImportOptions) -> DataError {
    let frames = export.time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let step_s = frames.fold(0.0, f64::max);
    let found = format!(
        "no command with both bodies tracked around it (frames are up to {step_s:.6} s apart)"
    );
    let expected =
        format!("tracked frames at most {} s apart ({})", options.max_gap_s, options.gap_key);
    DataError::Line { file: export.file.clone(), place: "all frames".to_owned(), found, expected }
}
