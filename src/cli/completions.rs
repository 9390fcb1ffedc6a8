//! `spinebench completions`.

use super::{Arguments, CommandResult};
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use std::io::Write as _;

/// Prints a script that completes this program's commands and options in a shell.
#[derive(Args)]
pub(super) struct CompletionsCommand {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

impl CompletionsCommand {
    #[allow(clippy::unnecessary_wraps)] // as every command
    pub(super) fn execute(self) -> CommandResult {
        let mut script = Vec::new();
        generate(self.shell, &mut Arguments::command(), "spinebench", &mut script);
        // A reader that has seen enough closes the pipe: no error.
        let _ = std::io::stdout().write_all(&script);
        Ok(())
    }
}
