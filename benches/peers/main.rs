//! Other simulators on the same robots, one after the other on one core: processor time against
//! error of the tip. Then packages that learn, on the same samples. `make peers` runs it;
//! `docs/evidence/peers.md` says what is compared and why like this.
#![allow(missing_docs, unreachable_pub)]

mod clock;
mod drive;
mod environment;
mod learning;
mod limits;
mod ours;
mod peer_till;
mod python;
mod statics;
mod suite;
mod table;
mod till;

use std::path::Path;
use std::process::ExitCode;

use spinebench::report;

fn main() -> ExitCode {
    // Cargo passes `--bench`; a word picks one robot, and then nothing is written, or `learning`;
    // `cases FOLDER` writes the robots for the comparison of environments.
    let words: Vec<String> =
        std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let done = if let ["cases", folder] = words[..] {
        python::write_cases(Path::new(folder))
    } else {
        run(words.first().copied())
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("peers: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn run(only: Option<&str>) -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if only != Some("learning") {
        simulators(root, only)?;
    }
    if only.is_none_or(|only| only == "learning") { learning::run(root) } else { Ok(()) }
}

fn simulators(root: &Path, only: Option<&str>) -> Result<(), String> {
    let results = suite::run(only)?;
    if only.is_some() {
        return Ok(());
    }
    let folder = root.join("results/peers");
    let words = |error: &dyn std::fmt::Display| error.to_string();
    let published = report::Published { peers: results.rows, ..report::Published::default() };
    let published = published.write(&folder).map_err(|error| words(&error))?;
    let text = environment::yaml(&results.facts)?;
    spinebench::data::write_atomic(&folder.join("environment.yaml"), text.as_bytes())
        .map_err(|e| words(&e))?;
    let figure = report::figure("peers").ok_or("no figure called peers")?;
    let files = (figure.render)(&published).map_err(|error| words(&error))?;
    report::write(&files, &folder, &root.join("plots")).map_err(|error| words(&error))
}
