//! `spinebench league confine`: puts itself in limits and becomes the program of a submission. The
//! harness of the league starts it; nobody types it.

use crate::cli::{CommandError, CommandResult};
use clap::{Args, value_parser};
use std::ffi::OsString;
use std::path::PathBuf;

/// Become a program that can read its own files, compute, and answer on its standard output.
#[derive(Args)]
pub(crate) struct ConfineCommand {
    /// Address space of the program, MiB.
    #[arg(long, value_name = "N", default_value_t = 2048)]
    #[arg(value_parser = value_parser!(u64).range(256..=1 << 20))]
    memory_mib: u64,
    /// Processor time of the program over all its threads, s.
    #[arg(long, value_name = "N", default_value_t = 600)]
    #[arg(value_parser = value_parser!(u64).range(1..=1 << 20))]
    cpu_s: u64,
    /// File or folder that the program may read; repeatable. It starts in the first.
    #[arg(long, value_name = "PATH", required = true)]
    read: Vec<PathBuf>,
    /// The program, and its arguments.
    #[arg(last = true, required = true, value_name = "PROGRAM")]
    program: Vec<OsString>,
}

impl ConfineCommand {
    /// Becomes the program; returns only with a reason why not.
    pub(crate) fn execute(&self) -> CommandResult {
        guarded::confine(self).map_err(CommandError::BadInput)
    }
}

/// The guards that this computer offers, such as "landlock abi 7, seccomp, rlimits", tried in a
/// thread that ends with them.
///
/// # Errors
/// What is missing, where a submission cannot be confined.
pub(crate) fn guards() -> Result<String, String> {
    let tried = std::thread::Builder::new().name("guards".to_owned()).spawn(guarded::guards);
    let tried = tried.map_err(|error| format!("found no thread to try guards in ({error})"))?;
    tried.join().unwrap_or_else(|_| Err("found a panic, expected guards".to_owned()))
}

#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
mod guarded {
    use super::ConfineCommand;
    use std::env::consts::{ARCH, OS};

    pub(super) fn confine(_: &ConfineCommand) -> Result<(), String> {
        guards().map(drop)
    }

    pub(super) fn guards() -> Result<String, String> {
        Err(format!(
            "found {OS} on {ARCH}, expected Linux 5.13 or later on x86_64 or aarch64, which can \
             confine a submission"
        ))
    }
}

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod calls;
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod guarded;
