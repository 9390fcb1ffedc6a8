//! Real robots: recordings that their laboratories published, in a folder of the user.

use std::path::{Path, PathBuf};

use super::LeagueError;
use super::robot::{LeagueRobot, MEASURED, RobotQuestion, seed_of};
use super::track::{MeasuredRobot, PinnedFile, ReadTrack};
use crate::calibration::like;
use crate::data::Recording;
use crate::effects::Model;
use crate::plants::{PlantSpec, SimulatedSpec};
use crate::runner::Digest;
use crate::specs::read_model;
use crate::tasks::read_to_explain;

/// The real robots of a track, whose recordings and models are in `folder`.
///
/// # Errors
/// [`LeagueError::Input`] for a file that is missing or has another content than the track says.
pub fn measured_robots(read: &ReadTrack, folder: &Path) -> Result<Vec<LeagueRobot>, LeagueError> {
    let one = |(name, robot): (&String, &MeasuredRobot)| {
        let key = format!("{}: measured.{name}", read.file.display());
        measured_robot(name, robot, folder, &key)
    };
    read.track.measured.iter().map(one).collect()
}

/// `key`: where the robot stands, in errors.
fn measured_robot(
    name: &str,
    robot: &MeasuredRobot,
    folder: &Path,
    key: &str,
) -> Result<LeagueRobot, LeagueError> {
    let (model_file, _) = pinned(&robot.model, folder, &format!("{key}.model"))?;
    let (file, digest) = pinned(&robot.recording, folder, &format!("{key}.recording"))?;
    let mut nominal = read_model(&model_file).map_err(LeagueError::input)?;
    let mut recording = read_to_explain(&file, &nominal, true).map_err(LeagueError::input)?;
    if let Some(point) = &robot.tip {
        name_tip(point, &mut recording, &mut nominal).map_err(|found| {
            LeagueError::input(format!("{key}.tip: found `{point}`, expected {found}"))
        })?;
    }
    let measured = divided(&recording, &robot.asked).map_err(|found| {
        let file = file.display();
        LeagueError::input(format!(
            "{key}.asked: found {found} in {file}, expected patterns of some rows with a tip"
        ))
    })?;
    Ok(LeagueRobot {
        name: name.to_owned(),
        family: name.to_owned(),
        engine: MEASURED.to_owned(),
        seed: seed_of(&digest),
        plant: PlantSpec::Simulated(Box::new(SimulatedSpec::new(nominal.clone(), 0.0))),
        nominal,
        effects: Vec::new(),
        load_kg: 0.0,
        change: None,
        measured: Some(measured),
    })
}

/// Place and digest of a file that has the content that the track expects.
fn pinned(
    expected: &PinnedFile,
    folder: &Path,
    key: &str,
) -> Result<(PathBuf, Digest), LeagueError> {
    let file = folder.join(&expected.file);
    let content = std::fs::read(&file).map_err(|error| {
        LeagueError::input(format!(
            "{key}.file: found no {} ({error}), expected what `benches/real/real.py --convert` writes",
            file.display()
        ))
    })?;
    let digest = Digest::of(&content);
    if digest.to_string() != expected.digest {
        let (file, expected) = (file.display(), &expected.digest);
        return Err(LeagueError::input(format!(
            "{key}.digest: found {digest} of {file}, expected {expected}"
        )));
    }
    Ok((file, digest))
}

/// Makes a tracked point the tip of a recording and of its model.
fn name_tip(point: &str, recording: &mut Recording, model: &mut Model) -> Result<(), String> {
    let recorded = recording.points.iter().position(|track| track.name == point);
    let (Some(at), Some(place)) = (recorded, model.tracking.points.remove(point)) else {
        return Err("a tracked point of the recording and of the model".to_owned());
    };
    let track = recording.points.remove(at);
    recording.tip_m = Some(track.position_m);
    recording.tip_quaternion = track.quaternion;
    model.tracking.tip = Some(place);
    Ok(())
}

/// What is given, and what is asked: the rows of these patterns in which the tip was measured.
fn divided(recording: &Recording, patterns: &[String]) -> Result<RobotQuestion, String> {
    let labels = recording.pattern.as_deref().unwrap_or_default();
    let tips_m = recording.tip_m.as_deref().unwrap_or_default();
    if let Some(none) = patterns.iter().find(|like_it| !labels.iter().any(|l| like(like_it, l))) {
        return Err(format!("no row of `{none}`"));
    }
    let is_asked = |row: usize| patterns.iter().any(|pattern| like(pattern, &labels[row]));
    let is_measured =
        |row: usize| recording.is_valid(row) && tips_m[row].iter().all(|value| value.is_finite());
    let (asked, given): (Vec<usize>, Vec<usize>) =
        (0..tips_m.len()).partition(|&row| is_asked(row));
    let asked: Vec<usize> = asked.into_iter().filter(|&row| is_measured(row)).collect();
    if asked.is_empty() || given.is_empty() {
        return Err(format!("{} asked and {} given rows", asked.len(), given.len()));
    }
    let at_rest = |rows: &[usize]| Some(vec![true; rows.len()]);
    Ok(RobotQuestion {
        given: Recording { at_rest: at_rest(&given), ..recording.rows(&given) },
        asked: Recording {
            at_rest: at_rest(&asked),
            tip_m: None,
            tip_quaternion: None,
            base: None,
            valid: None,
            points: Vec::new(),
            extra: Vec::new(),
            ..recording.rows(&asked)
        },
        tips_m: asked.iter().map(|&row| tips_m[row]).collect(),
    })
}
