//! `spinebench verify`.

use super::verify_claim::verify_claim;
use crate::cli::program::interrupted::exit_on_interrupt;
use crate::cli::program::shared::ThreadArgs;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::tables::read_csv;
use spinebench::rows::experiment::StageRow;
use spinebench::runner::{
    self, Campaign, CampaignEntry, Files, Manifest, Progress, RunOptions, Standard, Store,
};
use spinebench::specs::{ExperimentSet, PlantSpec};
use std::path::{Path, PathBuf};

/// Rerun the published experiments without stored results and compare with `results/` and `plots/`:
/// byte for byte on the kind of processor that computed them, number by number on another. With
/// `--claim`, rerun only the stages that one claim depends on.
#[derive(Args)]
pub(crate) struct VerifyCommand {
    /// Names of published experiments [default: all].
    #[arg(value_name = "EXPERIMENT")]
    experiments: Vec<String>,
    /// Check only this claim of `results/claims.csv`; prints the expected time first.
    #[arg(long, value_name = "NAME")]
    claim: Option<String>,
    /// Folder that contains `results/` and `plots/`.
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Relative tolerance of numbers [default: 0 on the processor that the manifest names, else
    /// 1e-6].
    #[arg(long, value_name = "SHARE")]
    tolerance: Option<f64>,
    #[command(flatten)]
    threads: ThreadArgs,
}

impl VerifyCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let bad = |words: String| CommandError::BadInput(words);
        if let Some(found) = self.tolerance.filter(|share| !(0.0..1.0).contains(share)) {
            return Err(bad(format!(
                "--tolerance: found {found}, expected a number of at least 0 and below 1"
            )));
        }
        let mut specs = Vec::new();
        for name in self.names().map_err(bad)? {
            let file = self.folder(&name).join("spec.yaml");
            specs.push(ExperimentSet::read(&file, &[], &[]).map_err(CommandError::bad_input)?);
        }
        if let Some(claim) = &self.claim {
            let with_standard = |set: ExperimentSet| {
                let standard = self.standard(&self.folder(&set.experiment.name));
                (set, standard)
            };
            let sets = specs.into_iter().map(with_standard).collect();
            let results = self.out.join("results");
            return verify_claim(claim, sets, &results, self.threads.jobs, progress);
        }
        let on_bench = |robot: &PlantSpec| matches!(robot, PlantSpec::Hardware(robot) if robot.rehearsal.is_none());
        if let Some(study) =
            specs.iter().find(|study| study.experiments().any(|spec| on_bench(&spec.plant)))
        {
            let name = &study.experiment.name;
            let words = format!(
                "{name}: found a `hardware` plant, which cannot be rerun, expected another plant; \
                 name the other experiments"
            );
            return Err(bad(words));
        }
        let campaign = Campaign::expand(specs).map_err(|failure| bad(failure.to_string()))?;
        let scratch =
            tempfile::Builder::new().prefix("spinebench-verify-").tempdir().map_err(|error| {
                CommandError::Failed(format!("cannot create a temporary folder: {error}"))
            })?;
        exit_on_interrupt(
            "interrupted; nothing was compared. The same command starts again from the beginning",
        );
        let (store, wanted) = (Store::at(scratch.path()), campaign.wanted());
        let outcomes = runner::execute(
            &campaign.graph,
            &store,
            &wanted,
            &RunOptions::new(self.threads.jobs, progress),
        )
        .map_err(|failure| CommandError::Failed(failure.to_string()))?;
        let mut wrong = Vec::new();
        for entry in &campaign.entries {
            let name = &entry.experiment.name;
            let publication = entry
                .publish(&outcomes)
                .map_err(|error| CommandError::Failed(format!("{name}: {error}")))?;
            let trail = runner::provenance(&campaign, entry, &outcomes, &store);
            match self.compare(entry, &publication.files, &trail) {
                Ok(said) => progress.say(&format!("{name}: {said}")),
                Err(said) => wrong.push(format!("{name}: differs: {said}")),
            }
        }
        if wrong.is_empty() { Ok(()) } else { Err(CommandError::Failed(wrong.join("\n"))) }
    }

    /// Compares one experiment. Returns a summary, or the first difference.
    fn compare(
        &self,
        entry: &CampaignEntry,
        files: &Files,
        trail: &[StageRow],
    ) -> Result<String, String> {
        let folder = self.folder(&entry.experiment.name);
        let standard = self.standard(&folder);
        runner::compare(files, &self.out, standard).map_err(|difference| {
            let published: Vec<StageRow> = read_csv(&folder.join("stages.csv")).unwrap_or_default();
            match runner::first_difference(&published, trail).filter(|_| !published.is_empty()) {
                Some(parting) => format!("{difference}; first stage that differs: {parting}"),
                None => difference.to_string(),
            }
        })?;
        Ok(match standard {
            Standard::Bytes => format!("{} files are the same", files.len()),
            Standard::Numbers(share) => {
                format!(
                    "the tables of {} files agree to {share:e} of each number; pictures not \
                     compared",
                    files.len()
                )
            }
        })
    }

    /// Byte equality on the published kind of processor, unless a tolerance is given.
    fn standard(&self, folder: &Path) -> Standard {
        let published =
            || Manifest::read(&folder.join("manifest.yaml")).map(|manifest| manifest.processor);
        match self.tolerance {
            Some(share) if share > 0.0 => Standard::Numbers(share),
            Some(_) => Standard::Bytes,
            None if published().is_ok_and(|processor| processor != runner::processor()) => {
                Standard::Numbers(1e-6)
            }
            None => Standard::Bytes,
        }
    }

    fn folder(&self, experiment: &str) -> PathBuf {
        self.out.join("results").join(experiment)
    }

    /// The requested experiments, or all published ones.
    fn names(&self) -> Result<Vec<String>, String> {
        if !self.experiments.is_empty() {
            return Ok(self.experiments.clone());
        }
        published_names(&self.out.join("results"))
    }
}

/// The published experiments of a folder of results, by name.
pub(super) fn published_names(results: &Path) -> Result<Vec<String>, String> {
    let none_published = |found: &str| {
        format!(
            "{}: found {found}, expected published experiments: run this in a checkout, or name \
             the folder that contains results/",
            results.display()
        )
    };
    if !results.is_dir() {
        return Err(none_published("no such folder"));
    }
    let folders = std::fs::read_dir(results).map_err(|error| none_published(&error.to_string()))?;
    let folders = folders.flatten().filter(|folder| folder.path().join("spec.yaml").is_file());
    let mut names: Vec<String> =
        folders.map(|folder| folder.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    if names.is_empty() { Err(none_published("none")) } else { Ok(names) }
}
