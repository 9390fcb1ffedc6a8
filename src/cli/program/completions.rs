//! `spinebench completions`.

use super::shared::print_all;
use crate::cli::{Arguments, CommandResult};
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

/// Print a shell script that completes the commands and options of this program.
#[derive(Args)]
pub(crate) struct CompletionsCommand {
    /// Shell to write the script for.
    #[arg(value_enum)]
    shell: Shell,
}

impl CompletionsCommand {
    #[allow(clippy::unnecessary_wraps)] // the signature of every command
    pub(crate) fn execute(self) -> CommandResult {
        let mut script = Vec::new();
        generate(self.shell, &mut Arguments::command(), "spinebench", &mut script);
        print_all(&script);
        Ok(())
    }
}
