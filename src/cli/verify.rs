//! `spinebench verify`.

use super::shared::Telling;
use super::{Ended, Outcome};
use clap::Args;
use spinebench::runner::{self, Campaign, Store};
use spinebench::specs::Experiment;
use std::path::{Path, PathBuf};

/// Reruns the published experiments from nothing and compares with `results/` and `plots/`, byte for byte.
#[derive(Args)]
pub(super) struct Verify {
    /// Names of published experiments; all when none is given.
    #[arg(value_name = "EXPERIMENT")]
    experiments: Vec<String>,
    /// Folder that `results/` and `plots/` are in.
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    #[command(flatten)]
    telling: Telling,
}

impl Verify {
    pub(super) fn carry_out(self) -> Outcome {
        let bad = |words: String| Ended::BadInput(words);
        let mut specs = Vec::new();
        for name in self.names().map_err(bad)? {
            let file = self.out.join("results").join(&name).join("spec.yaml");
            specs.push(Experiment::read(&file, &[]).map_err(|error| bad(error.to_string()))?);
        }
        let campaign = Campaign::expand(specs).map_err(|failure| bad(failure.to_string()))?;
        let scratch = Scratch::new().map_err(|error| Ended::No(format!("no temporary folder: {error}")))?;
        let progress = self.telling.progress();
        let (store, wanted) = (Store::at(&scratch.0), campaign.wanted());
        let outcomes = runner::execute(&campaign.graph, &store, &wanted, self.telling.jobs, &progress)
            .map_err(|failure| Ended::No(failure.to_string()))?;
        for entry in &campaign.entries {
            let name = &entry.experiment.name;
            let publication = entry.publish(&outcomes).map_err(|error| Ended::No(format!("{name}: {error}")))?;
            runner::compare(&publication.files, &self.out)
                .map_err(|difference| Ended::No(format!("{name}: differs: {difference}")))?;
            progress.say(&format!("{name}: {} files are the same", publication.files.len()));
        }
        Ok(())
    }

    /// The experiments that are asked for, or all that are published.
    fn names(&self) -> Result<Vec<String>, String> {
        if !self.experiments.is_empty() {
            return Ok(self.experiments.clone());
        }
        let results = self.out.join("results");
        let nothing = |found: &str| format!("{}: found {found}, expected published experiments", results.display());
        let folders = std::fs::read_dir(&results).map_err(|error| nothing(&error.to_string()))?;
        let folders = folders.flatten().filter(|folder| folder.path().join("spec.yaml").is_file());
        let mut names: Vec<String> = folders.map(|folder| folder.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        if names.is_empty() { Err(nothing("none")) } else { Ok(names) }
    }
}

/// A temporary folder that goes when it is dropped.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> std::io::Result<Scratch> {
        let folder = std::env::temp_dir().join(format!("spinebench-verify-{}", std::process::id()));
        std::fs::create_dir_all(Path::new(&folder))?;
        Ok(Scratch(folder))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0); // what stays is in the system's temporary folder
    }
}
