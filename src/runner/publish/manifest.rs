//! What is needed to repeat a run, and what it took. Beside the trail of stages the only published
//! file that holds clocks.

use super::provenance::stages_behind;
use super::publish_all::RunFacts;
use crate::rows::experiment::StageRow;
use crate::runner::campaign::{Campaign, CampaignEntry};
use crate::runner::execute::outcomes::Outcomes;
use crate::runner::graph::timing::Timing;
use crate::runner::store::Store;
use crate::specs::{Document, SpecError, to_yaml};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// The manifest of one experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Name of the experiment.
    pub experiment: String,
    /// Version of this program.
    pub version: String,
    /// Revision of the sources in the working directory, `+` when changed since; empty outside a
    /// repository.
    pub git_revision: String,
    /// Root seed.
    pub seed: u64,
    /// Repetitions.
    pub seeds: u64,
    /// Number of the first of them.
    #[serde(default, skip_serializing_if = "is_first")]
    pub first_seed: u64,
    /// Operating system and architecture.
    pub system: String,
    /// Processor as the system names it.
    pub processor: String,
    /// Threads of the run.
    pub threads: usize,
    /// Seconds on the clock of the whole run, all experiments of the command together.
    pub run_wall_s: f64,
    /// Stages of this experiment by kind; those shared with other experiments count in each.
    pub stages: BTreeMap<String, StageTimes>,
}

fn is_first(seed: &u64) -> bool {
    *seed == 0
}

/// Stages of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageTimes {
    /// How many the experiment has.
    pub count: usize,
    /// How many were computed in this run; the others came from the store or were not needed.
    pub computed: usize,
    /// Seconds on the clock, when they were computed.
    pub wall_s: f64,
    /// Seconds on a processor, when they were computed.
    pub cpu_s: f64,
}

impl Manifest {
    /// The manifest of an entry after a run of its campaign.
    pub fn new(
        campaign: &Campaign,
        entry: &CampaignEntry,
        outcomes: &Outcomes,
        store: &Store,
        run: &RunFacts,
    ) -> Manifest {
        let needed = stages_behind(campaign, entry);
        let mut stages = stage_times(campaign, needed.iter().copied(), outcomes);
        for number in needed.into_iter().filter(|&number| outcomes.timings[number].is_none()) {
            let (kind, _, key) = campaign.graph.describe(number);
            let Timing { wall_s, cpu_s } =
                store.noted(kind, &key).map(|note| note.timing).unwrap_or_default();
            let times = stages.entry(kind).or_default();
            times.wall_s += wall_s;
            times.cpu_s += cpu_s;
        }
        Manifest {
            experiment: entry.experiment.name.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            git_revision: run.revision.to_owned(),
            seed: entry.experiment.seed,
            seeds: entry.experiment.seeds,
            first_seed: entry.experiment.first_seed,
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            processor: processor(),
            threads: (run.threads)(entry),
            run_wall_s: run.wall_s,
            stages: stages.into_iter().map(|(kind, times)| (kind.to_owned(), times)).collect(),
        }
    }

    /// The manifest of an experiment whose parts have run one after the other or on several
    /// machines.
    pub(crate) fn merged<'a>(
        parts: impl ExactSizeIterator<Item = &'a Manifest> + Clone,
        trail: &[StageRow],
    ) -> Manifest {
        if let (1, Some(alone)) = (parts.len(), parts.clone().next()) {
            return alone.clone();
        }
        let each = |text: fn(&Manifest) -> &str| {
            let mut texts: Vec<&str> = parts.clone().map(text).collect();
            texts.dedup();
            texts.join(", ")
        };
        let mut stages: BTreeMap<String, StageTimes> = BTreeMap::new();
        for row in trail {
            let times = stages.entry(row.stage.clone()).or_default();
            times.count += 1;
            times.wall_s += row.wall_s;
            times.cpu_s += row.cpu_s;
        }
        for (kind, times) in parts.clone().flat_map(|part| &part.stages) {
            stages.entry(kind.clone()).or_default().computed += times.computed;
        }
        Manifest {
            experiment: each(|part| &part.experiment),
            version: each(|part| &part.version),
            git_revision: each(|part| &part.git_revision),
            seed: parts.clone().next().map_or(0, |part| part.seed),
            seeds: parts.clone().map(|part| part.seeds).sum(),
            first_seed: parts.clone().map(|part| part.first_seed).min().unwrap_or(0),
            system: each(|part| &part.system),
            processor: each(|part| &part.processor),
            threads: parts.clone().map(|part| part.threads).max().unwrap_or(0),
            run_wall_s: parts.map(|part| part.run_wall_s).sum(),
            stages,
        }
    }

    /// Reads a published manifest.
    ///
    /// # Errors
    /// [`SpecError`] for a file that is none.
    pub fn read(file: &Path) -> Result<Manifest, SpecError> {
        Document::read(file, &[], &[])?.parse()
    }

    /// The manifest as YAML.
    ///
    /// # Errors
    /// What the serialiser says.
    pub fn to_yaml(&self) -> Result<Vec<u8>, String> {
        to_yaml(self).map(String::into_bytes)
    }
}

/// What these stages took in this run, by kind.
pub fn stage_times<'a>(
    campaign: &'a Campaign,
    numbers: impl IntoIterator<Item = usize>,
    outcomes: &Outcomes,
) -> BTreeMap<&'a str, StageTimes> {
    let mut stages: BTreeMap<&str, StageTimes> = BTreeMap::new();
    for number in numbers {
        let times = stages.entry(campaign.graph.describe(number).0).or_default();
        times.count += 1;
        if let Some(Timing { wall_s, cpu_s }) = outcomes.timings[number] {
            times.computed += 1;
            times.wall_s += wall_s;
            times.cpu_s += cpu_s;
        }
    }
    stages
}

/// Revision of the sources in the working directory, `+` when changed since; empty outside a
/// repository.
pub fn git_revision() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git")
            .args(arguments)
            .output()
            .ok()
            .filter(|output| output.status.success())?;
        String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned())
    };
    let Some(revision) = git(&["rev-parse", "HEAD"]) else { return String::new() };
    let changed = git(&["status", "--porcelain", "--untracked-files=no"])
        .is_none_or(|changes| !changes.is_empty());
    if changed { revision + "+" } else { revision }
}

/// The processor as the system names it.
pub fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name"));
    line.and_then(|line| line.split(':').nth(1))
        .map_or_else(|| "unknown".to_owned(), |name| name.trim().to_owned())
}
