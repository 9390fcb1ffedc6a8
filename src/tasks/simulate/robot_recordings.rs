//! Recordings of one robot, read from files and checked against its model.

use std::collections::BTreeMap;
use std::path::Path;

use crate::data::{DataError, Recording, RecordingSource};
use crate::effects::{Model, Starts};

/// Reads commands to simulate and checks that their number of tendons is the model's, and that
/// gravity stays the same where trials go on from one another. Poses `at_rest` may have any times.
///
/// # Errors
/// [`DataError`] for a file that holds no commands of this robot.
pub fn read_commands<'a>(
    source: impl Into<RecordingSource<'a>>,
    model: &Model,
    at_rest: bool,
) -> Result<Recording, DataError> {
    let source = source.into();
    let file = source.name();
    let mut commands = if at_rest {
        Recording::read_pose_commands(source)
    } else {
        Recording::read_commands(source)
    }?;
    let expected = model.robot.tendons.angles_deg.len();
    of_tendons(&mut commands, file, &model.drive_gains(), expected)?;
    commands.check_points(file, &model.tracking.names())?;
    commands.check_travel(file, model.robot.backbone.length_m)?;
    check_one_gravity(file, &commands, model)?;
    Ok(commands)
}

/// Reads a recording that a calibration fits: of the model's robot, under one gravity where trials
/// go on from one another. Poses `at_rest` may have any times.
///
/// # Errors
/// [`DataError`] for a file that holds no such recording.
pub fn read_to_calibrate<'a>(
    source: impl Into<RecordingSource<'a>>,
    model: &Model,
    at_rest: bool,
) -> Result<Recording, DataError> {
    let source = source.into();
    let file = source.name();
    let measured = read_measured(source, model, at_rest)?;
    check_one_gravity(file, &measured, model)?;
    check_duration(file, &measured, at_rest || measured.rows_at_rest() > 0)?;
    Ok(measured)
}

/// Reads a recording that a discovery explains: of the model's robot, with plausible loads. Poses
/// `at_rest` may have any times.
///
/// # Errors
/// [`DataError`] for a file that holds no such recording.
pub fn read_to_explain<'a>(
    source: impl Into<RecordingSource<'a>>,
    model: &Model,
    at_rest: bool,
) -> Result<Recording, DataError> {
    let source = source.into();
    let file = source.name();
    let measured = read_measured(source, model, at_rest)?;
    check_duration(file, &measured, at_rest || measured.rows_at_rest() > 0)?;
    measured.check_loads(file)?;
    Ok(measured)
}

fn check_duration(file: &Path, measured: &Recording, at_rest: bool) -> Result<(), DataError> {
    if at_rest { Ok(()) } else { measured.check_duration(file) }
}

/// Reads a recording of the model's robot and checks its number of tendons and that tip and
/// commands are within reach.
fn read_measured(
    source: RecordingSource,
    model: &Model,
    at_rest: bool,
) -> Result<Recording, DataError> {
    let file = source.name();
    let mut measured =
        if at_rest { Recording::read_poses(source) } else { Recording::read_as_marked(source) }?;
    let tendons = model.robot.tendons.angles_deg.len();
    of_tendons(&mut measured, file, &model.drive_gains(), tendons)?;
    measured.check_points(file, &model.tracking.names())?;
    let length_m = model.robot.backbone.length_m;
    measured.check_reach(file, model.robot.base_m, length_m)?;
    measured.check_travel(file, length_m)?;
    Ok(measured)
}

/// Whether these recordings are of poses at rest: by what was `asked`, or by their rows (`at_rest`).
///
/// # Errors
/// [`DataError`] for the first one that is of poses at rest where another row is not.
pub fn are_at_rest<'a>(
    asked: bool,
    recordings: impl IntoIterator<Item = (&'a Path, &'a Recording)>,
) -> Result<bool, DataError> {
    if asked {
        return Ok(true);
    }
    let (mut first, mut marked) = (None, None);
    for (file, recording) in recordings {
        let (at_rest, rows) = (recording.rows_at_rest(), recording.len());
        let first_at_rest = *first.get_or_insert(at_rest > 0);
        marked = marked.or((at_rest > 0).then_some(file));
        if (at_rest > 0) != first_at_rest || (at_rest > 0 && at_rest < rows) {
            return Err(DataError::Column {
                file: marked.unwrap_or(file).to_owned(),
                place: "line 1",
                column: "at_rest".to_owned(),
                found: "poses at rest and rows in motion".to_owned(),
                expected: "one kind in all recordings (--static takes all rows as poses at rest)"
                    .to_owned(),
            });
        }
    }
    Ok(marked.is_some())
}

/// Gives a recording the commands of tendons that its drives give with these `gains`, and checks
/// that it has the robot's number of tendons.
///
/// # Errors
/// [`DataError::Column`] for another number, and as [`Recording::convert_drives`].
pub fn of_tendons(
    commands: &mut Recording,
    file: &Path,
    gains: &BTreeMap<String, Vec<(usize, f64)>>,
    expected: usize,
) -> Result<(), DataError> {
    commands.convert_drives(file, gains, expected)?;
    let found = commands.tendons();
    if found == expected {
        return Ok(());
    }
    let column = commands.actuation.column(found.min(expected));
    let (found, expected) =
        (format!("{found} tendons"), format!("{expected}, the number of the robot's tendons"));
    Err(DataError::Column { file: file.to_owned(), place: "line 1", column, found, expected })
}

/// Refuses a gravity that changes from trial to trial where trials go on from one another: the
/// robot is the same in all.
///
/// # Errors
/// [`DataError::Line`] for the first row with another gravity.
pub fn check_one_gravity(
    file: &Path,
    commands: &Recording,
    model: &Model,
) -> Result<(), DataError> {
    let all = commands.gravity_m_s2.as_deref().unwrap_or_default();
    let Some(row) = all.iter().position(|gravity_m_s2| *gravity_m_s2 != all[0]) else {
        return Ok(());
    };
    if model.tracking.starts != Starts::Continue {
        return Ok(());
    }
    Err(DataError::Line {
        file: file.to_owned(),
        place: format!("row {}", row + 1),
        found: "another gravity than in the first trial".into(),
        expected: "the same in all with `starts: continue`".into(),
    })
}
