//! `spinebench simulate`.

use crate::cli::program::outputs::check_recording;
use crate::cli::program::shared::StartsArg;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::Recording;
use spinebench::data::recording::Extra;
use spinebench::effects::Model;
use spinebench::rod::SolveStatus;
use spinebench::runner::Progress;
use spinebench::specs::read_model;
use spinebench::tasks::{SimulationOptions, TOUCHES_ITSELF, read_commands, simulate_recording};
use std::path::{Path, PathBuf};

/// Drive the rod model with the commands of a recording (displacements or tensions) and write a
/// recording.
#[derive(Args)]
pub(crate) struct SimulateCommand {
    /// Model file.
    #[arg(long, value_name = "MODEL.yaml")]
    model: PathBuf,
    /// Commands: a recording, with or without tip columns; CSV or Parquet.
    #[arg(long, value_name = "IN.csv")]
    commands: PathBuf,
    /// Recording to write, with tip, tracked points, orientations, tensions and solver status in
    /// full precision; CSV or Parquet.
    #[arg(long, value_name = "OUT.csv")]
    out: PathBuf,
    /// Compute each row as the equilibrium under its own command.
    #[arg(long = "static")]
    at_rest: bool,
    #[command(flatten)]
    starts: StartsArg,
}

impl SimulateCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let model = self.starts.applied(read_model(&self.model).map_err(CommandError::bad_input)?);
        let commands =
            read_commands(&self.commands, &model, self.at_rest).map_err(CommandError::bad_input)?;
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
            return Err(nothing_solved(&self.model, &model, &self.out, &played));
        }
        if failed > 0 {
            let (all, out) = (played.len(), self.out.display());
            progress.notice(&format!(
                "{failed} of {all} rows could not be solved; see the column solver_status of {out}"
            ));
        }
        let itself = touching_itself(&played);
        if itself > 0 {
            let (all, out) = (played.len(), self.out.display());
            progress.notice(&format!(
                "in {itself} of {all} rows the robot touches itself; the model does not simulate \
                 self-contact; see the column {TOUCHES_ITSELF} of {out}"
            ));
        }
        progress.say(&written(&self.out, &played));
        Ok(())
    }
}

/// The error of a recording in which no row could be solved, with the number of the model that is
/// most unusual, or the accuracy that the finest grid does not reach.
pub(crate) fn nothing_solved(
    file: &Path,
    model: &Model,
    out: &Path,
    played: &Recording,
) -> CommandError {
    let (out, name, rows) = (out.display(), file.display(), played.len());
    let statuses = statuses(played);
    let all_are = |name: SolveStatus| {
        !statuses.is_empty() && statuses.iter().all(|status| status == name.name())
    };
    let too_coarse = all_are(SolveStatus::UnderResolved);
    let suspect = match model.unusual_number(file) {
        Some(words) => words,
        None if too_coarse => format!(
            "{name}: robot.resolution.static_tolerance_m: found {}, which the finest grid does not \
             reach at this curvature; expected a value ten times larger",
            model.robot.resolution.static_tolerance_m
        ),
        None if all_are(SolveStatus::Flutters) => format!(
            "{name}: robot.loads: every equilibrium under these follower loads is unstable \
             (growing oscillations); expected smaller loads, or a simulation without --static"
        ),
        None => format!(
            "no parameter of {name} is unusual; check whether the commands are too large for this \
             robot"
        ),
    };
    CommandError::Failed(format!(
        "none of {rows} rows could be solved (written to {out}); {suspect}"
    ))
}

/// What was written, in one line.
pub(crate) fn written(file: &Path, recording: &Recording) -> String {
    let (trials, rows) = (recording.trials().len(), recording.len());
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    let (of_trials, of_rows) = (plural(trials), plural(rows));
    format!("wrote {}: {trials} trial{of_trials}, {rows} row{of_rows}", file.display())
}

/// Number of rows that the solver could not solve.
pub(crate) fn failures(played: &Recording) -> usize {
    played.valid.iter().flatten().filter(|valid| !**valid).count()
}

/// Number of rows in which the robot touches itself.
fn touching_itself(played: &Recording) -> usize {
    match played.extra.iter().find(|(name, _)| name == TOUCHES_ITSELF) {
        Some((_, Extra::Numbers(flags))) => flags.iter().filter(|flag| **flag > 0.0).count(),
        _ => 0,
    }
}

/// The column `solver_status`; empty for a recording without it.
fn statuses(played: &Recording) -> &[String] {
    match played.extra.iter().find(|(name, _)| name == "solver_status") {
        Some((_, Extra::Text(cells))) => cells,
        _ => &[],
    }
}
