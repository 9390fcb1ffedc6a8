//! `spinebench simulate`.

use super::outputs::check_recording;
use super::shared::StartsArg;
use super::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::Recording;
use spinebench::data::recording::Extra;
use spinebench::effects::{Model, Starts};
use spinebench::runner::Progress;
use spinebench::specs::read_model;
use spinebench::tasks::{SimulationOptions, simulate_recording};
use std::path::{Path, PathBuf};

/// Drive the rod model with the commands of a recording (displacements or tensions) and write a recording.
#[derive(Args)]
pub(super) struct SimulateCommand {
    /// Model file.
    #[arg(long, value_name = "MODEL.yaml")]
    model: PathBuf,
    /// Commands: a recording, with or without tip columns; CSV or Parquet.
    #[arg(long, value_name = "IN.csv")]
    commands: PathBuf,
    /// Recording to write, with tip, tracked points, orientations, tensions and solver status in full precision; CSV or
    /// Parquet.
    #[arg(long, value_name = "OUT.csv")]
    out: PathBuf,
    /// Compute each row as the equilibrium under its own command.
    #[arg(long = "static")]
    at_rest: bool,
    #[command(flatten)]
    starts: StartsArg,
}

impl SimulateCommand {
    pub(super) fn execute(self, progress: &Progress) -> CommandResult {
        let model = self.starts.applied(read_model(&self.model).map_err(CommandError::bad_input)?);
        let commands = read_commands(&self.commands, &model, self.at_rest)?;
        one_gravity(&self.commands, &commands, &model)?;
        check_recording(&self.out, commands.len())?;
        progress.step("simulating");
        let played = simulate_recording(
            &model,
            &commands,
            &SimulationOptions { at_rest: self.at_rest, ..SimulationOptions::default() },
        );
        progress.done();
        played.write(&self.out).map_err(CommandError::bad_input)?;
        if let Some(words) = model.tracking.starts.told() {
            progress.notice(words);
        }
        let failed = failures(&played);
        if failed == played.len() && failed > 0 {
            return Err(nothing_solved(&self.model, &model, &self.out, failed));
        }
        if failed > 0 {
            let (all, out) = (played.len(), self.out.display());
            progress
                .notice(&format!("{failed} of {all} rows could not be solved; see the column solver_status of {out}"));
        }
        progress.say(&written(&self.out, &played));
        Ok(())
    }
}

/// Reads commands and checks that their number of tendons is the model's. Poses `at_rest` may have any times.
pub(super) fn read_commands(file: &Path, model: &Model, at_rest: bool) -> Result<Recording, CommandError> {
    let read = if at_rest { Recording::read_pose_commands } else { Recording::read_commands };
    let mut commands = read(file).map_err(CommandError::bad_input)?;
    let expected = model.robot.tendons.angles_deg.len();
    commands.convert_drives(file, &model.drive_gains(), expected).map_err(CommandError::bad_input)?;
    same_tendons(file, &commands, expected)?;
    commands.check_points(file, &model.tracking.names()).map_err(CommandError::bad_input)?;
    Ok(commands)
}

/// Refuses a gravity that changes from trial to trial where trials go on from one another: the robot is the same in all.
pub(super) fn one_gravity(file: &Path, commands: &Recording, model: &Model) -> CommandResult {
    let all = commands.gravity_m_s2.as_deref().unwrap_or_default();
    let Some(row) = all.iter().position(|own| *own != all[0]) else { return Ok(()) };
    if model.tracking.starts != Starts::Continue {
        return Ok(());
    }
    let words = "found another gravity than in the first trial, expected the same in all with `starts: continue`";
    Err(CommandError::BadInput(format!("{}, row {}: {words}", file.display(), row + 1)))
}

/// Reads a recording of the model's robot and checks its number of tendons and that tip and commands are within reach.
/// Poses `at_rest` may have any times.
pub(super) fn read_measured(file: &Path, model: &Model, at_rest: bool) -> Result<Recording, CommandError> {
    let read = if at_rest { Recording::read_poses } else { Recording::read };
    let mut measured = read(file).map_err(CommandError::bad_input)?;
    let tendons = model.robot.tendons.angles_deg.len();
    measured.convert_drives(file, &model.drive_gains(), tendons).map_err(CommandError::bad_input)?;
    same_tendons(file, &measured, tendons)?;
    measured.check_points(file, &model.tracking.names()).map_err(CommandError::bad_input)?;
    let length_m = model.robot.backbone.length_m;
    measured.check_reach(file, model.robot.base_m, length_m).map_err(CommandError::bad_input)?;
    measured.check_travel(file, length_m).map_err(CommandError::bad_input)?;
    Ok(measured)
}

/// Reads a recording as [`read_measured`] does; the tip must be in it.
pub(super) fn read_measured_tip(file: &Path, model: &Model, at_rest: bool) -> Result<Recording, CommandError> {
    let measured = read_measured(file, model, at_rest)?;
    if measured.tip_m.is_some() {
        return Ok(measured);
    }
    let words = "found tracked points and no tip, expected the columns tip_x_m, tip_y_m and tip_z_m";
    Err(CommandError::BadInput(format!("{}, line 1: {words}", file.display())))
}

/// Checks that a recording has the robot's number of tendons.
pub(super) fn same_tendons(file: &Path, commands: &Recording, expected: usize) -> CommandResult {
    let found = commands.tendons();
    if found == expected {
        return Ok(());
    }
    let column = commands.actuation.column(found.min(expected));
    let words = format!(
        "{}, line 1, column `{column}`: found {found} tendons, expected {expected}, the number of the robot's tendons",
        file.display()
    );
    Err(CommandError::BadInput(words))
}

/// The error of a recording in which no row could be solved, with the number of the model that is most unusual.
pub(super) fn nothing_solved(file: &Path, model: &Model, out: &Path, rows: usize) -> CommandError {
    let (out, file) = (out.display(), file.display());
    let suspect = match model.robot.suspect() {
        Some((key, value)) => format!("{file}: {key}: found {value}, which few robots have; check its unit"),
        None => format!("no number of {file} is unusual; check the sizes of the commands against the robot's"),
    };
    CommandError::Failed(format!("none of {rows} rows could be solved (written to {out}); {suspect}"))
}

/// What was written, in one line.
pub(super) fn written(file: &Path, recording: &Recording) -> String {
    let (trials, rows) = (recording.trials().len(), recording.len());
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    let (of_trials, of_rows) = (plural(trials), plural(rows));
    format!("wrote {}: {trials} trial{of_trials}, {rows} row{of_rows}", file.display())
}

/// Number of rows that the solver could not solve.
pub(super) fn failures(played: &Recording) -> usize {
    let status = played.extra.iter().find(|(name, _)| name == "solver_status");
    match status {
        Some((_, Extra::Text(cells))) => cells.iter().filter(|cell| *cell != "converged").count(),
        _ => 0,
    }
}
