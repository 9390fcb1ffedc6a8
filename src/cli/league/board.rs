//! `spinebench league table`.

use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::write_atomic;
use spinebench::league::board::board;
use spinebench::report::league;
use std::path::PathBuf;

/// Compare the scores in a folder: a board as CSV, JSON, Markdown, page and figure. Ranks differ
/// only where 95 % intervals do not overlap.
#[derive(Args)]
pub(crate) struct TableCommand {
    /// Folder with files `score.json`, in it or below it.
    scores: PathBuf,
    /// Folder to write the board in [default: that of the scores].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl TableCommand {
    pub(crate) fn execute(&self) -> CommandResult {
        let rows = board(&self.scores)?;
        let out = self.out.as_ref().unwrap_or(&self.scores);
        for artifact in league::board(&rows).map_err(CommandError::failed)? {
            write_atomic(&out.join(&artifact.name), &artifact.bytes)
                .map_err(CommandError::failed)?;
        }
        println!("{}", out.join("board.html").display());
        Ok(())
    }
}
