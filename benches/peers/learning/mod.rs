//! Learning beside the packages that people would use for it: the same samples, the same likelihood
//! from the same start, the same network; processor time of one thread, in rounds in which ours and
//! every package take their turns.

mod ours;
mod package;
mod product;
mod rounds;
mod samples;
mod task;

use std::path::Path;

use serde::Serialize;
use spinebench::report::{self, Published};

use crate::environment::Machine;

/// Rounds of a published comparison.
const ROUNDS: u64 = 5;

/// What is worth knowing besides the rows.
#[derive(Debug, Serialize)]
struct LearningEnvironment {
    #[serde(flatten)]
    machine: Machine,
    /// Processes that wanted to run, on average over a minute, before and after.
    load: [String; 2],
    rounds: u64,
    /// Versions of the packages.
    versions: serde_json::Map<String, serde_json::Value>,
    /// Packages that did not run, and why.
    skipped: serde_json::Map<String, serde_json::Value>,
}

/// Measures and publishes; `ROUNDS=1` in the environment is a look, which publishes nothing.
///
/// # Errors
/// What makes a comparison impossible: a missing model, a file that cannot be written.
pub fn run(root: &Path) -> Result<(), String> {
    let words = |error: &dyn std::fmt::Display| error.to_string();
    let rounds = match std::env::var("ROUNDS") {
        Ok(text) if !text.is_empty() => {
            text.parse().map_err(|_| format!("ROUNDS: found `{text}`, expected a number"))?
        }
        _ => ROUNDS,
    };
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join("peers_learning");
    std::fs::create_dir_all(&scratch).map_err(|error| words(&error))?;
    println!("\nlearning: samples of the robot, then {rounds} rounds");
    let samples = samples::Samples::make(root)?;
    samples.write(&scratch)?;
    let before = load();
    let found = rounds::run(&samples, &scratch, rounds);
    let map = |pairs: Vec<(String, String)>| {
        pairs.into_iter().map(|(name, word)| (name, word.into())).collect()
    };
    let environment = LearningEnvironment {
        machine: Machine::this(),
        load: [before, load()],
        rounds,
        versions: map(found.versions),
        skipped: map(found.skipped),
    };
    let folder = root.join("results/peers");
    let (results, plots) =
        if rounds == ROUNDS { (folder, root.join("plots")) } else { (scratch.clone(), scratch) };
    let published = Published { learning_peers: found.rows, ..Published::default() };
    let published = published.write(&results).map_err(|error| words(&error))?;
    let text = serde_yaml::to_string(&environment).map_err(|error| words(&error))?;
    spinebench::data::write_atomic(&results.join("learning_environment.yaml"), text.as_bytes())
        .map_err(|error| words(&error))?;
    let figure = report::figure("peers_learning").ok_or("no figure called peers_learning")?;
    let files = (figure.render)(&published).map_err(|error| words(&error))?;
    report::write(&files, &results, &plots).map_err(|error| words(&error))?;
    println!(
        "learning: {} and {}",
        results.join("learning.md").display(),
        plots.join("peers_learning.png").display()
    );
    Ok(())
}

/// Average number of processes that wanted to run in the last minute.
fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace().next().unwrap_or("unknown").to_owned()
}
