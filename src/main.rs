//! The command line: arguments in, exit status out. What the commands do is in `cli`.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
