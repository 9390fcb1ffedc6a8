//! How runs scale: one and two threads on this machine, and recorded stage times replayed on clusters of up to a
//! thousand nodes. `make scaling` runs it; `docs/scaling.md` says what is assumed.
#![allow(missing_docs, unreachable_pub)]

mod cluster;
mod measure;
mod recorded;

use cluster::Assumed;
use measure::Scratch;
use recorded::Recorded;
use spinebench::data::rows::ScalingRow;
use spinebench::report::{self, Published};
use spinebench::runner::{Campaign, Store};
use spinebench::specs::Experiment;
use std::path::Path;
use std::process::ExitCode;

/// Seeds of the campaign that is replayed: the most that a spec may have.
const SEEDS: u64 = 1000;
const NODES: [usize; 10] = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("scaling: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let spec = root.join("experiments/table1.yaml");
    let scratch = Scratch::new()?;
    let mut rows = measure::threads(&scratch, &spec)?;
    let recorded = Recorded::of(&Store::at(scratch.cache("threads1")))?;
    let sets = [format!("seeds={SEEDS}")];
    let experiment = Experiment::read(&spec, &sets).map_err(|error| error.to_string())?;
    let campaign = Campaign::expand(vec![experiment]).map_err(|error| error.to_string())?;
    let assumed = Assumed::default();
    for nodes in NODES {
        rows.extend(cluster::replay(&campaign, &recorded, &assumed, nodes));
    }
    publish(root, rows)
}

fn publish(root: &Path, scaling: Vec<ScalingRow>) -> Result<(), String> {
    let folder = root.join("results/scaling");
    let published = Published { scaling, ..Published::default() };
    let published = published.write(&folder).map_err(|error| error.to_string())?;
    let figure = report::figure("scaling").ok_or("no figure called scaling")?;
    let files = (figure.render)(&published).map_err(|error| error.to_string())?;
    report::write(&files, &folder, &root.join("plots")).map_err(|error| error.to_string())
}
