//! Specs: what they would run, and running them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::Instant;

use pyo3::prelude::*;
use spinebench::runner::{
    self, Campaign, Need, Progress, RunFacts, RunOptions, Store, Style, store_folder,
};
use spinebench::specs::ExperimentSet;

use crate::calculations::{about, json};
use crate::calls::{claim_global_threads, long, long_watched};
use crate::errors::Fault;

/// Where and how specs are run.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct RunArguments {
    out: PathBuf,
    cache: Option<PathBuf>,
    sets: Vec<String>,
    sweeps: Vec<String>,
    jobs: usize,
    /// Policies of this process by name, as entries of a spec, in JSON.
    own: String,
}

/// Reads specs, each with policies of its own in every set of trials; with the notes about each.
fn campaign(
    specs: &[PathBuf],
    arguments: &RunArguments,
) -> Result<(Campaign, Vec<Vec<String>>), Fault> {
    let read = |file: &PathBuf| experiments(file, arguments);
    let experiments = specs.iter().map(read).collect::<Result<Vec<_>, Fault>>()?;
    let notes = experiments.iter().map(|set| set.notes.clone()).collect();
    Ok((Campaign::expand(experiments).map_err(Fault::words)?, notes))
}

fn experiments(file: &Path, arguments: &RunArguments) -> Result<ExperimentSet, Fault> {
    let RunArguments { sets, sweeps, own, .. } = arguments;
    let read = ExperimentSet::read(file, sets, sweeps)?;
    let own: BTreeMap<String, serde_json::Value> =
        serde_json::from_str(own).map_err(|error| Fault::Run(error.to_string()))?;
    if own.is_empty() {
        return Ok(read);
    }
    let mut sets = sets.clone();
    sets.extend(own.iter().map(|(name, policy)| format!("policies.outside.{name}={policy}")));
    let with_own = |path: String, policies: &[String]| {
        let more = own.keys().filter(|name| !policies.contains(name));
        let all: Vec<&String> = policies.iter().chain(more).collect();
        format!("{path}.policies={}", serde_json::json!(all))
    };
    let runs = &read.experiment.runs;
    sets.extend(
        runs.reach
            .iter()
            .enumerate()
            .map(|(k, sweep)| with_own(format!("runs.reach[{k}]"), &sweep.policies)),
    );
    sets.extend(runs.track.iter().map(|track| with_own("runs.track".to_owned(), &track.policies)));
    Ok(ExperimentSet::read(file, &sets, sweeps)?)
}

/// What specs would run, as JSON.
#[pyfunction]
pub(crate) fn _plan(
    py: Python<'_>,
    specs: Vec<PathBuf>,
    arguments: RunArguments,
) -> PyResult<String> {
    long(py, move |_| {
        let (campaign, notes) = campaign(&specs, &arguments)?;
        let needs = runner::plan(
            &campaign.graph,
            &Store::at(store_folder(arguments.cache.as_deref())),
            &campaign.wanted(),
        );
        let runs = campaign.entries.iter().flat_map(|entry| {
            let name = &entry.experiment.name;
            entry.cells().into_iter().map(move |cell| (name, cell))
        });
        let runs: Vec<_> = runs
            .map(|(name, cell)| (name, cell.label, needs[cell.stage] != Need::Compute))
            .collect();
        let mut stages: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
        for (number, need) in needs.iter().enumerate() {
            let [stored, to_compute] = stages.entry(campaign.graph.describe(number).0).or_default();
            *stored += usize::from(*need == Need::Cached);
            *to_compute += usize::from(*need == Need::Compute);
        }
        json(&serde_json::json!({ "runs": runs, "stages": stages, "notes": notes.concat() }))
    })
}

/// Runs specs and writes tables and figures; `tell` hears how many stages are done, and of how
/// many. Returns what was computed as JSON.
#[pyfunction]
pub(crate) fn _run(
    py: Python<'_>,
    specs: Vec<PathBuf>,
    arguments: RunArguments,
    tell: Option<Py<PyAny>>,
) -> PyResult<String> {
    claim_global_threads()?;
    let progress = Arc::new(Progress::new(Style::Quiet));
    let (counted, mut told) = (Arc::clone(&progress), (0, 0));
    let watch = move |py: Python<'_>| {
        let counts = counted.counts();
        if let Some(tell) = tell.as_ref().filter(|_| counts != told) {
            told = counts;
            tell.bind(py).call1(counts)?;
        }
        Ok(())
    };
    long_watched(py, watch, move |stop| {
        let (campaign, notes) = campaign(&specs, &arguments)?;
        let RunArguments { out, cache, jobs, .. } = arguments;
        std::fs::create_dir_all(&out).map_err(|error| about(&out, error))?;
        let (revision, began, store) =
            (runner::git_revision(), Instant::now(), Store::at(store_folder(cache.as_deref())));
        let options = RunOptions { stop: stop.flag(), ..RunOptions::new(jobs, &progress) };
        let outcomes = runner::execute(&campaign.graph, &store, &campaign.wanted(), &options)
            .map_err(|failure| Fault::Run(failure.to_string()))?;
        stop.check()?;
        let threads = if jobs > 0 { jobs } else { available_parallelism().map_or(1, usize::from) };
        let facts = RunFacts {
            revision: &revision,
            threads: &|_| threads,
            wall_s: began.elapsed().as_secs_f64(),
        };
        let published =
            runner::publish_all(&campaign, &outcomes, &store, &out, &facts).map_err(Fault::Run)?;
        let experiments: Vec<serde_json::Value> = campaign
            .entries
            .iter()
            .zip(&published)
            .zip(&notes)
            .map(|((entry, publication), notes)| {
                let notices: Vec<&String> = notes.iter().chain(&publication.notices).collect();
                serde_json::json!({
                    "name": entry.experiment.name,
                    "files": publication.files.keys().map(|file| out.join(file)).collect::<Vec<_>>(),
                    "failed_trials": publication.failed,
                    "notices": notices,
                })
            })
            .collect();
        let failures: Vec<String> = outcomes.failures.iter().map(ToString::to_string).collect();
        let (computed, cached) = (outcomes.computed, outcomes.cached);
        json(&serde_json::json!({
            "computed": computed, "cached": cached, "failures": failures, "experiments": experiments
        }))
    })
}
