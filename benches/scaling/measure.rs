//! Whole runs of the program on this machine.

use spinebench::rows::experiment::ScalingRow;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;
use tempfile::TempDir;

/// Repetitions of the experiment that is measured.
const SEEDS: &str = "2";

/// A folder that goes when it is dropped.
pub struct Scratch(TempDir);

impl Scratch {
    pub fn new() -> Result<Scratch, String> {
        tempfile::tempdir().map(Scratch).map_err(|error| error.to_string())
    }

    /// The store of the run called `name`.
    pub fn cache(&self, name: &str) -> PathBuf {
        self.0.path().join(name).join("cache")
    }

    fn begin(&self, name: &str, spec: &Path, threads: usize) -> Result<Child, String> {
        let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
        command.arg("run").arg(spec).args([
            "--seeds",
            SEEDS,
            "--quiet",
            "--threads",
            &threads.to_string(),
        ]);
        command.arg("--out").arg(self.0.path().join(name)).arg("--cache").arg(self.cache(name));
        command.stdout(Stdio::null()).spawn().map_err(|error| error.to_string())
    }
}

fn end(mut child: Child) -> Result<(), String> {
    let status = child.wait().map_err(|error| error.to_string())?;
    if status.success() { Ok(()) } else { Err(format!("a run ended with {status}")) }
}

/// One and two threads from nothing, two processes of one thread beside each other, and a run that
/// finds everything.
pub fn threads(scratch: &Scratch, spec: &Path) -> Result<Vec<ScalingRow>, String> {
    let timed = |runs: &[(&str, usize)]| -> Result<f64, String> {
        let began = Instant::now();
        let children = runs.iter().map(|(name, threads)| scratch.begin(name, spec, *threads));
        children.collect::<Result<Vec<_>, _>>()?.into_iter().try_for_each(end)?;
        Ok(began.elapsed().as_secs_f64())
    };
    let one_s = timed(&[("threads1", 1)])?;
    let two_s = timed(&[("threads2", 2)])?;
    // What the machine gives to two at once that share nothing: no program can do better.
    let apart_s = timed(&[("apart1", 1), ("apart2", 1)])?;
    let again_s = timed(&[("threads1", 1)])?;
    let row = |system: &str, workers: u64, wall_s: f64, efficiency: f64, bound: &str| ScalingRow {
        system: system.to_owned(),
        workers,
        stages: 0,
        wall_s,
        efficiency,
        store_gb: f64::NAN,
        store_mb_s: f64::NAN,
        bound: bound.to_owned(),
        store_operations: 0,
        locks_lost: 0,
        polls: 0,
    };
    Ok(vec![
        row("threads", 1, one_s, 1.0, ""),
        row("threads", 2, two_s, one_s / (2.0 * two_s), ""),
        row("two processes apart", 2, apart_s, one_s / apart_s, "the machine"),
        row("everything stored", 1, again_s, f64::NAN, ""),
    ])
}
