//! `spinebench completions`.

use super::{Arguments, Outcome};
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use std::io::Write as _;

/// Prints a script that completes this program's commands and options in a shell.
#[derive(Args)]
pub(super) struct Completions {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    #[allow(clippy::unnecessary_wraps)] // as every command
    pub(super) fn carry_out(self) -> Outcome {
        let mut script = Vec::new();
        generate(self.shell, &mut Arguments::command(), "spinebench", &mut script);
        // A reader that has seen enough closes the pipe: no error.
        let _ = std::io::stdout().write_all(&script);
        Ok(())
    }
}
