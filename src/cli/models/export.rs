//! `spinebench export`.

use super::several::poses_at_rest;
use crate::cli::program::outputs::{check_ending, check_file};
use crate::cli::{CommandError, CommandResult};
use clap::{Args, Subcommand};
use spinebench::data::findings::ResidualRow;
use spinebench::data::mcap::{Shown, to_mcap};
use spinebench::data::{Recording, tables, write_atomic};
use spinebench::runner::Progress;
use spinebench::specs::read_model;
use spinebench::tasks::scene_of_recording;
use std::path::PathBuf;

/// Export a recording for other programs.
#[derive(Args)]
pub(crate) struct ExportCommand {
    #[command(subcommand)]
    to: To,
}

#[derive(Subcommand)]
enum To {
    Mcap(McapExport),
}

/// Export a recording as MCAP, which Foxglove and other viewers open: poses, commands, the robot,
/// residuals.
#[derive(Args)]
struct McapExport {
    /// Recording, measured or simulated; CSV or Parquet.
    #[arg(value_name = "REC.csv")]
    recording: PathBuf,
    /// File to write.
    #[arg(long, value_name = "REC.mcap")]
    out: PathBuf,
    /// Add the shape that this model predicts for the recording's commands, with a frame for each
    /// disk.
    #[arg(long, value_name = "MODEL.yaml")]
    model: Option<PathBuf>,
    /// Add the residuals of a discovery on this recording: its `residuals.csv`.
    #[arg(long, value_name = "residuals.csv")]
    residuals: Option<PathBuf>,
    /// Treat every row as a pose at rest; row k of a trial gets the time k seconds.
    #[arg(long = "static")]
    at_rest: bool,
}

impl ExportCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let To::Mcap(mcap) = self.to;
        mcap.execute(progress)
    }
}

/// Bytes of a row in the file, at most, with a shape.
const ROW_BYTES: usize = 8000;

impl McapExport {
    fn execute(self, progress: &Progress) -> CommandResult {
        check_ending(&self.out, &["mcap"])?;
        let read = if self.at_rest { Recording::read_poses } else { Recording::read_as_marked };
        let recording = read(&self.recording).map_err(CommandError::bad_input)?;
        let at_rest =
            poses_at_rest(self.at_rest, [(self.recording.as_path(), &recording)], progress)?;
        let model =
            self.model.as_deref().map(read_model).transpose().map_err(CommandError::bad_input)?;
        let residuals = self.residuals.as_deref().map(tables::read_csv::<ResidualRow>).transpose();
        let residuals = residuals.map_err(CommandError::bad_input)?.unwrap_or_default();
        check_file(&self.out, recording.len() * ROW_BYTES)?;
        progress.step("simulating");
        let scene =
            |model| scene_of_recording("robot", &self.recording, &recording, model, at_rest);
        let robot = model.as_ref().map(scene).transpose().map_err(CommandError::bad_input)?;
        progress.done();
        let shown =
            Shown { recording: &recording, at_rest, robot: robot.as_ref(), residuals: &residuals };
        write_atomic(&self.out, &to_mcap(&shown)).map_err(CommandError::bad_input)?;
        let (rows, out) = (recording.len(), self.out.display());
        progress.say(&format!("wrote {out}: {rows} row{}", if rows == 1 { "" } else { "s" }));
        Ok(())
    }
}
