//! Arguments that several commands take.

use crate::cli::CommandError;
use clap::{Args, ValueEnum};
use spinebench::effects::{Model, Starts};
use spinebench::runner::{Campaign, Progress, Store, Style, store_folder};
use spinebench::specs::{ExperimentSet, SpecError};
use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Prints to standard output. A reader may close the pipe early; that is no error.
pub(crate) fn print_all(text: &[u8]) {
    let _ = std::io::stdout().write_all(text);
}

/// The experiments to run.
#[derive(Args)]
pub(crate) struct SpecArgs {
    /// Experiment files.
    #[arg(required = true, value_name = "SPEC.yaml")]
    specs: Vec<PathBuf>,
    /// Number of repetitions of each experiment, including data and training; overrides the specs.
    #[arg(long, value_name = "N")]
    seeds: Option<u64>,
    /// Override a key of every spec, such as `gp.starts=21`; repeatable.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Sweep a field of every spec: `gp.kernel=matern32,matern52`, or `from:to:count`,
    /// `log:from:to:count`, `random:from:to:count`; repeatable, the sweeps form a product.
    #[arg(long, value_name = "KEY=VALUES")]
    sweep: Vec<String>,
}

impl SpecArgs {
    /// Reads and expands the experiments; `note` tells what the user should know of their specs.
    pub(crate) fn campaign(&self, note: impl Fn(&str)) -> Result<Campaign, CommandError> {
        let mut sets = self.set.clone();
        sets.extend(self.seeds.map(|seeds| format!("seeds={seeds}")));
        let read = |file: &PathBuf| ExperimentSet::read(file, &sets, &self.sweep);
        let experiments: Result<Vec<ExperimentSet>, SpecError> =
            self.specs.iter().map(read).collect();
        let experiments = experiments.map_err(|error| CommandError::BadInput(error.to_string()))?;
        experiments.iter().flat_map(|set| &set.notes).for_each(|text| note(text));
        let mut names = BTreeSet::new();
        for (study, file) in experiments.iter().zip(&self.specs) {
            if !names.insert(&study.experiment.name) {
                let (name, file) = (&study.experiment.name, file.display());
                refuse!(
                    "{file}: name: found `{name}`, expected a name that no other given spec uses"
                );
            }
        }
        Campaign::expand(experiments).map_err(|failure| CommandError::BadInput(failure.to_string()))
    }
}

/// Where results of stages are stored.
#[derive(Args)]
pub(crate) struct CacheArgs {
    /// Folder of stored results [default: $SPINEBENCH_CACHE, else .spinebench/cache of the
    /// checkout, elsewhere spinebench in the folder of the user's caches].
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

impl CacheArgs {
    pub(crate) fn store(&self) -> Store {
        Store::at(store_folder(self.cache.as_deref()))
    }
}

/// How to report, before or after the name of the command.
#[derive(Args)]
pub(crate) struct ReportingArgs {
    /// Suppress output other than results, notes and errors.
    #[arg(long, global = true)]
    quiet: bool,
    /// Format of messages on stderr.
    #[arg(long, global = true, value_enum, default_value_t = LogFormat::Human)]
    log: LogFormat,
}

/// How many threads to use.
#[derive(Args)]
pub(crate) struct ThreadArgs {
    /// Number of threads; 0 means one for each processor.
    #[arg(long, visible_alias = "threads", value_name = "N", default_value_t = 0)]
    pub(crate) jobs: usize,
}

/// Where experiments are written.
#[derive(Args)]
pub(crate) struct ResultsArg {
    /// Folder to write `results/` and `plots/` in [default: the current one; `out` if the file
    /// `results/PUBLISHED` exists, which marks the results as published].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl ResultsArg {
    /// The folder. Published results are replaced only by somebody who names their folder.
    pub(crate) fn folder(&self, progress: &Progress) -> PathBuf {
        if let Some(named) = &self.out {
            return named.clone();
        }
        if !Path::new("results/PUBLISHED").is_file() {
            return PathBuf::from(".");
        }
        progress.notice(
            "results/ and plots/ here are published; this run writes to out/ (`--out \
                         .` replaces them)",
        );
        PathBuf::from("out")
    }
}

/// How trials start.
#[derive(Args)]
pub(crate) struct StartsArg {
    /// State at the start of a trial; overrides the model's `tracking.starts`: at rest at home, at
    /// rest under the trial's first command, or the final state of the previous trial.
    #[arg(long, value_enum)]
    starts: Option<StartsChoice>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum StartsChoice {
    Home,
    Anywhere,
    Continue,
}

impl StartsArg {
    /// The model with this start, where one is given.
    pub(crate) fn applied(&self, mut model: Model) -> Model {
        model.tracking.starts = match self.starts {
            None => model.tracking.starts,
            Some(StartsChoice::Home) => Starts::Home,
            Some(StartsChoice::Anywhere) => Starts::Anywhere,
            Some(StartsChoice::Continue) => Starts::Continue,
        };
        model
    }
}

/// Format of stderr.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LogFormat {
    /// A progress bar and sentences, for people.
    Human,
    /// One JSON object per line, for machines.
    Json,
}

impl ReportingArgs {
    pub(crate) fn progress(&self) -> Progress {
        Progress::new(match (self.log, self.quiet) {
            (LogFormat::Json, _) => Style::Json,
            (LogFormat::Human, true) => Style::Quiet,
            (LogFormat::Human, false) => Style::Human,
        })
    }
}
