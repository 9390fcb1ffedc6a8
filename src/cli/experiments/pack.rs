//! `spinebench pack`.

use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::packed::{pack, unpack};
use std::path::PathBuf;

/// Replace tables `x.csv` of results by `x.parquet`, a fifth of the size. Every command reads
/// tables of results in both formats.
#[derive(Args)]
pub(crate) struct PackCommand {
    /// Tables: CSV, or Parquet with `--undo`.
    #[arg(required = true, value_name = "TABLE")]
    tables: Vec<PathBuf>,
    /// Restore the CSV files byte for byte.
    #[arg(long)]
    undo: bool,
}

impl PackCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let convert = if self.undo { unpack } else { pack };
        self.tables.iter().try_for_each(|table| convert(table)).map_err(CommandError::bad_input)?;
        // A table may be a link to another one: both are read before either goes.
        self.tables.iter().try_for_each(std::fs::remove_file).map_err(CommandError::failed)
    }
}
