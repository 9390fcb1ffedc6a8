//! The files that an experiment publishes, as bytes: writing them is one more step, comparing them
//! another.

use super::claims::{evaluate, per_robot};
use super::failed_cells::{FailedCell, failed_cells};
use super::gp_range_ends;
use super::metrics::Tables;
use crate::data::{DataError, TableRow, tables, write_atomic_batch};
use crate::report::{self, FigureContext, OutputFolder, Published, ReportError};
use crate::rows::experiment::ClaimRow;
use crate::rows::population::{RobotClaimRow, RobotRow};
use crate::runner::campaign::{CampaignEntry, PointStages};
use crate::runner::execute::outcomes::Outcomes;
use crate::specs::Experiment;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Why results could not be published.
#[derive(Debug, thiserror::Error)]
pub enum PublishError {
    /// A table cannot be written.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A figure cannot be drawn.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The spec cannot be written as YAML.
    #[error("spec.yaml: {0}")]
    Spec(String),
}

/// Files by their path below the output folder.
pub type Files = BTreeMap<PathBuf, Vec<u8>>;

/// What an experiment yields.
#[derive(Default)]
pub struct Publication {
    /// Its files, without the manifest.
    pub files: Files,
    /// What became of the paper's claims.
    pub claims: Vec<ClaimRow>,
    /// Trials and tracking runs that failed.
    pub failed: usize,
    /// Cells of which every trial failed.
    pub failed_cells: Vec<FailedCell>,
    /// What a user must know: figures that could not be made, and why (with failed stages their rows
    /// may be missing), and fits that ended at an end of their range.
    pub notices: Vec<String>,
    /// What a user may like to know, and `--quiet` does not tell.
    pub remarks: Vec<String>,
}

impl CampaignEntry {
    /// Makes the files of this experiment from the results of its stages.
    ///
    /// # Errors
    /// [`PublishError`] for a table or figure that cannot be made.
    pub fn publish(&self, outcomes: &Outcomes) -> Result<Publication, PublishError> {
        let [point] = self.points.as_slice() else { return self.publish_sweep(outcomes) };
        if !self.sweep.is_empty() {
            return self.publish_sweep(outcomes);
        }
        self.publish_rows(point, &point.tables(outcomes))
    }

    /// Makes the files of one experiment from its rows as they are published, so that they can be
    /// made again from those.
    ///
    /// # Errors
    /// As [`Entry::publish`].
    pub(crate) fn publish_rows(
        &self,
        point: &PointStages,
        tables: &Tables,
    ) -> Result<Publication, PublishError> {
        let folder = Path::new("results").join(&self.experiment.name);
        let mut tables = tables.as_published(&folder)?;
        let claims = self.claims(point, &tables);
        tables.published.claims.clone_from(&claims);
        if self.experiment.population.is_some() {
            tables.published.robot_claims = self.robot_claims(point, &tables);
        }
        tables.published.context = figure_context(&self.experiment);
        let mut files = Files::new();
        files.insert(folder.join("spec.yaml"), self.spec_yaml());
        for (name, bytes) in Published::csv_files(&[&tables.published], |_| Vec::new())? {
            files.insert(folder.join(name), bytes);
        }
        let name = &self.experiment.name;
        let mut notices = draw(name, &self.experiment.figures, &tables.published, &mut files);
        let mut remarks = Vec::new();
        if !self.experiment.claims.is_empty() && !tables.published.context.is_paper_robot {
            remarks.push(format!(
                "{name}: claims are not evaluated: they apply to the paper's robot only"
            ));
        }
        self.tell_range_ends(&[&tables.published], &mut notices, &mut remarks);
        let failed = tables.published.failed();
        // Those of many robots are not about the paper's setting.
        let claims = if self.experiment.population.is_some() { Vec::new() } else { claims };
        let failed_cells = failed_cells(&tables.published);
        Ok(Publication { files, claims, failed, failed_cells, notices, remarks })
    }

    /// Adds the sentence about hyper-parameters of Gaussian processes at an end of their range.
    pub(crate) fn tell_range_ends(
        &self,
        parts: &[&Published],
        notices: &mut Vec<String>,
        remarks: &mut Vec<String>,
    ) {
        let prior = self.experiment.gp_config().noise_prior;
        let has_prior = prior.is_some_and(|prior| prior.std_m.is_some());
        let rows = parts.iter().flat_map(|part| &part.gps);
        if let Some(note) = gp_range_ends::note(&self.experiment.name, has_prior, rows) {
            if note.is_warning { notices.push(note.sentence) } else { remarks.push(note.sentence) }
        }
    }

    /// What became of the claims at one point; none where the robot is not the paper's.
    pub(crate) fn claims(&self, point: &PointStages, tables: &Tables) -> Vec<ClaimRow> {
        if !point.experiment.is_of_paper_robot() {
            return Vec::new();
        }
        let seeds: Vec<u64> = point.repetitions.iter().map(|repetition| repetition.seed).collect();
        let trainings: Vec<String> = point.experiment.training.keys().cloned().collect();
        evaluate(&self.experiment.name, &self.experiment.claims, tables, &seeds, &trainings)
    }

    /// On how many robots the claims hold, where every repetition has a robot of its own.
    fn robot_claims(&self, point: &PointStages, tables: &Tables) -> Vec<RobotClaimRow> {
        let seeds: Vec<u64> = point.repetitions.iter().map(|repetition| repetition.seed).collect();
        let trainings: Vec<String> = point.experiment.training.keys().cloned().collect();
        per_robot(&self.experiment.claims, tables, &seeds, &trainings)
    }

    /// The resolved spec: what it extends, includes and leaves to defaults filled in. It runs as it
    /// is.
    pub fn spec_yaml(&self) -> Vec<u8> {
        format!("# The spec as it was run, with everything filled in.\n{}", self.spec_yaml)
            .into_bytes()
    }
}

/// What figures know of an experiment beside its rows.
pub(super) fn figure_context(experiment: &Experiment) -> FigureContext {
    FigureContext {
        outside: experiment.policies.outside.clone(),
        is_paper_robot: experiment.is_of_paper_robot(),
    }
}

/// Draws figures of an experiment and adds their files: the pictures of the figure of the
/// experiment's name in `plots/`, those of others in a folder there. Returns what could not be drawn.
pub(super) fn draw(
    experiment: &str,
    figures: &[String],
    published: &Published,
    files: &mut Files,
) -> Vec<String> {
    let folder = Path::new("results").join(experiment);
    let mut notices = Vec::new();
    for name in figures {
        let Some(figure) = report::figure(name) else { continue };
        let plots = Path::new("plots");
        let plots = if *name == experiment { plots.into() } else { plots.join(experiment) };
        let artifacts = (figure.render)(published).unwrap_or_else(|error| {
            notices.push(format!("{experiment}: {error}"));
            Vec::new()
        });
        for artifact in artifacts {
            let path = match artifact.folder {
                OutputFolder::Plots => plots.join(&artifact.name),
                OutputFolder::Results => folder.join(&artifact.name),
            };
            // Two figures of one experiment may each have a summary: the later one carries its
            // figure's name.
            let exists = files.contains_key(&path);
            let path = if exists {
                path.with_file_name(format!("{name}_{}", artifact.name))
            } else {
                path
            };
            files.insert(path, artifact.bytes);
        }
    }
    notices
}

/// Adds the table of these rows to the files of `folder`, unless there are none.
///
/// # Errors
/// [`DataError::Write`] for rows that make no table.
pub fn put<R: TableRow>(files: &mut Files, folder: &Path, rows: &[R]) -> Result<(), DataError> {
    if !rows.is_empty() {
        let path = folder.join(R::TABLE.file);
        let bytes = tables::to_csv(&path, rows)?;
        files.insert(path, bytes);
    }
    Ok(())
}

/// The claims of all experiments that are published in a folder `results`, with those of `fresh` in
/// place of older ones, as a table and a picture.
///
/// # Errors
/// [`PublishError`] for published claims that cannot be read, or a picture that cannot be drawn.
pub fn all_claims(
    out: &Path,
    fresh: &BTreeMap<String, Vec<ClaimRow>>,
) -> Result<Files, PublishError> {
    let results = Path::new("results");
    let mut by_experiment = fresh.clone();
    for folder in std::fs::read_dir(out.join(results)).into_iter().flatten().flatten() {
        let (name, path) = (
            folder.file_name().to_string_lossy().into_owned(),
            folder.path().join(ClaimRow::TABLE.file),
        );
        let many_robots = folder.path().join(RobotRow::TABLE.file).is_file();
        if !by_experiment.contains_key(&name) && path.is_file() && !many_robots {
            let table = tables::read_csv_beside(&path, |column| column.contains('.'));
            // Earlier versions wrote claims without their experiment.
            let Ok((swept, claims)) = table else { continue };
            // The claims of a sweep are about its points, not about the paper's settings.
            if swept.is_empty() {
                by_experiment.insert(name, claims);
            }
        }
    }
    let claims: Vec<ClaimRow> = by_experiment.into_values().flatten().collect();
    let mut files = Files::new();
    put(&mut files, results, &claims)?;
    if let (Some(figure), false) = (report::figure("claims"), claims.is_empty()) {
        let published = Published { claims, ..Published::default() };
        for artifact in (figure.render)(&published)? {
            let folder =
                if artifact.folder == OutputFolder::Plots { Path::new("plots") } else { results };
            files.insert(folder.join(artifact.name), artifact.bytes);
        }
    }
    Ok(files)
}

/// Writes files below `out`: all of them or, where one cannot be written, none.
///
/// # Errors
/// [`DataError::Write`] for the first file that cannot be written.
pub fn write_files(out: &Path, files: &Files) -> Result<(), DataError> {
    write_atomic_batch(files.iter().map(|(path, bytes)| (out.join(path), bytes.as_slice())))
}
