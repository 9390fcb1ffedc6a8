//! `spinebench report`.

use super::verify::published_names;
use crate::cli::viewer::path_scenes;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::write_atomic;
use spinebench::report::overview::{ClaimCost, ExperimentFacts, OverviewFacts, overview};
use spinebench::report::published_rows;
use spinebench::rows::experiment::StageRow;
use spinebench::runner::{Campaign, Manifest, SEEDS_NEEDED, published_cost};
use spinebench::specs::{Experiment, ExperimentSet};
use std::path::{Path, PathBuf};

/// Frames of the robot on the path, a policy.
const PATH_FRAMES: usize = 150;

/// Write all published results on one page, `results/report.html`: claims with their ranges and
/// verdicts, Table I, the figures with their values, controllers, repair, populations, sweeps,
/// discovery, real robots, and the provenance of the numbers. The page works offline.
#[derive(Args)]
pub(crate) struct ReportCommand {
    /// Folder that contains `results/`.
    #[arg(long, value_name = "DIR", default_value = ".")]
    results: PathBuf,
    /// The page [default: `results/report.html` in that folder].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl ReportCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let results = self.results.join("results");
        let names = published_names(&results).map_err(CommandError::BadInput)?;
        // A path on a robot that is not simulated, or of an earlier build, has no scenes.
        let path = path_scenes(&results.join("fig8"), None, &[], PATH_FRAMES).unwrap_or_default();
        let mut facts = OverviewFacts {
            path,
            repetitions_needed: SEEDS_NEEDED as u64,
            switch_threshold_m: switch_threshold_m(&results.join("fig8")),
            ..OverviewFacts::default()
        };
        for name in &names {
            let folder = results.join(name);
            facts.experiments.extend(experiment_facts(&folder));
            facts.costs.extend(claim_costs(&folder));
        }
        let page = overview(&results, &facts).map_err(CommandError::bad_input)?;
        let file = self.out.unwrap_or_else(|| results.join("report.html"));
        write_atomic(&file, page.as_bytes()).map_err(CommandError::failed)?;
        println!("wrote {}: {} kB", file.display(), page.len() / 1000);
        Ok(())
    }
}

/// Error above which C switches; nothing where the spec does not run any more.
fn switch_threshold_m(folder: &Path) -> Option<f64> {
    let experiment = Experiment::read(&folder.join("spec.yaml"), &[]).ok()?;
    Some(experiment.policies.c.switch_threshold_m)
}

/// What the manifest of an experiment says; nothing where there is none.
fn experiment_facts(folder: &Path) -> Option<ExperimentFacts> {
    let manifest = Manifest::read(&folder.join("manifest.yaml")).ok()?;
    let cpu_s = manifest.stages.values().map(|times| times.cpu_s).sum();
    Some(ExperimentFacts {
        name: manifest.experiment,
        version: manifest.version,
        revision: manifest.git_revision,
        seeds: manifest.seeds,
        processor: manifest.processor,
        cpu_s,
    })
}

/// What each claim of an experiment costs; nothing where its spec does not run any more.
fn claim_costs(folder: &Path) -> Vec<ClaimCost> {
    let Ok(set) = ExperimentSet::read(&folder.join("spec.yaml"), &[], &[]) else {
        return Vec::new();
    };
    if set.experiment.claims.is_empty() || set.experiment.population.is_some() {
        return Vec::new();
    }
    let trail: Vec<StageRow> = published_rows(folder).unwrap_or_default();
    let Ok(campaign) = Campaign::expand([set]) else { return Vec::new() };
    let entry = &campaign.entries[0];
    let cost = |claim: &spinebench::specs::PaperClaim| {
        let (_, cpu_s) = published_cost(&campaign, &entry.wanted_for(claim), &trail);
        ClaimCost { experiment: entry.experiment.name.clone(), claim: claim.claim.clone(), cpu_s }
    };
    entry.experiment.claims.iter().map(cost).collect()
}
