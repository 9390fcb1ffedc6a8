//! The command line: arguments in, exit status out. The commands are in `cli`.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
