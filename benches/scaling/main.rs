//! How runs scale: one and two threads on this machine, and recorded stage times replayed on
//! clusters of up to a thousand nodes. `make scaling` runs it; `docs/evidence/scaling.md` says what is
//! assumed.
#![allow(missing_docs, unreachable_pub)]

mod cluster;
mod ideal;
mod measure;
mod recorded;

use cluster::{Assumed, Costs};
use measure::Scratch;
use recorded::Recorded;
use spinebench::report::{self, Published};
use spinebench::rows::experiment::ScalingRow;
use spinebench::runner::{Campaign, Store};
use spinebench::specs::Experiment;
use std::path::{Path, PathBuf};
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

/// `cargo bench --bench scaling -- DIR` takes stage times from the store DIR of a run and measures
/// nothing: the table keeps its measured rows.
fn run() -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let spec = root.join("experiments/table1.yaml");
    let scratch = Scratch::new()?;
    let given = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let (mut rows, store) = match given {
        Some(store) => {
            let published = Published::read(&root.join("results/scaling"))
                .map_err(|error| error.to_string())?;
            let measured = published.scaling.into_iter().filter(|row| row.stages == 0);
            (measured.collect(), PathBuf::from(store))
        }
        None => (measure::threads(&scratch, &spec)?, scratch.cache("threads1")),
    };
    let recorded = Recorded::of(&Store::at(store))?;
    let sets = [format!("seeds={SEEDS}")];
    let experiment = Experiment::read(&spec, &sets).map_err(|error| error.to_string())?;
    let campaign = Campaign::expand(vec![experiment]).map_err(|error| error.to_string())?;
    let costs = Costs::new(&campaign.graph, &recorded);
    for nodes in NODES {
        rows.extend(replayed(&campaign, &costs, nodes));
    }
    publish(root, rows)
}

/// The campaign on `nodes` nodes of one processor each: without and with the costs of a cluster.
fn replayed(campaign: &Campaign, costs: &Costs, nodes: usize) -> [ScalingRow; 2] {
    let graph = &campaign.graph;
    let row = |system: &str, wall_s: f64, bytes: f64, bound: &str| ScalingRow {
        system: system.to_owned(),
        workers: nodes as u64,
        stages: graph.len() as u64,
        wall_s,
        efficiency: costs.all_s() / (nodes as f64 * wall_s),
        store_gb: bytes / 1e9,
        store_mb_s: bytes / 1e6 / wall_s,
        bound: bound.to_owned(),
        store_operations: 0,
        locks_lost: 0,
        polls: 0,
    };
    let ideal_s = costs.ideal_s(graph, nodes);
    let chain = if costs.chain_s(graph) > 0.9 * ideal_s { "longest chain" } else { "" };
    let done = cluster::replay(campaign, costs, &Assumed::default(), nodes);
    let losses = [
        (done.starting_s, "starting workers"),
        (done.store_s, "store"),
        (done.idle_s, "waiting for stages"),
    ];
    let loss =
        losses.iter().max_by(|one, other| one.0.total_cmp(&other.0)).map_or("", |loss| loss.1);
    let workers = ScalingRow {
        store_operations: done.operations,
        locks_lost: done.locks_lost,
        polls: done.polls,
        ..row("workers", done.wall_s, done.bytes, loss)
    };
    [row("ideal cluster", ideal_s, costs.all_bytes(graph), chain), workers]
}

fn publish(root: &Path, scaling: Vec<ScalingRow>) -> Result<(), String> {
    let folder = root.join("results/scaling");
    let published = Published { scaling, ..Published::default() };
    let published = published.write(&folder).map_err(|error| error.to_string())?;
    let figure = report::figure("scaling").ok_or("no figure called scaling")?;
    let files = (figure.render)(&published).map_err(|error| error.to_string())?;
    report::write(&files, &folder, &root.join("plots")).map_err(|error| error.to_string())
}
