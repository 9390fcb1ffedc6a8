//! Parts of one experiment that machines without a common store have run (`first_seed`), as the
//! experiment that they are.

use super::manifest::Manifest;
use super::metrics::Tables;
use super::results::{Publication, PublishError, put};
use crate::data::{DataError, tables};
use crate::rows::experiment::StageRow;
use crate::runner::campaign::Campaign;
use crate::runner::graph::Failure;
use crate::specs::{Experiment, ExperimentSet, SpecError};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Why parts could not be put together.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A published spec or manifest cannot be read.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// A published table cannot be read.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A folder has something else than a part that goes with the others.
    #[error("{}: found {found}, expected {expected}", place.display())]
    Part {
        /// The folder, or a file of it.
        place: PathBuf,
        /// What is there.
        found: String,
        /// What should be.
        expected: String,
    },
    /// The parts are good; what they make cannot be published.
    #[error(transparent)]
    Publish(#[from] Box<PublishError>),
    /// The spec of all of them cannot be expanded.
    #[error(transparent)]
    Expand(#[from] Failure),
}

/// What one machine has published of an experiment.
struct PublishedPart {
    folder: PathBuf,
    experiment: Experiment,
    manifest: Manifest,
    tables: Tables,
    trail: Vec<StageRow>,
}

/// Reads `results/<experiment>` of several machines and makes the files of the experiment of all
/// their repetitions, which must follow each other. Claims are judged and figures drawn anew, as
/// one run would have; of one folder alone, too. The name of the experiment comes with it.
///
/// # Errors
/// [`MergeError`] for the first folder that cannot be read, is not whole or does not go with the
/// others.
pub fn merge(folders: &[PathBuf]) -> Result<(String, Publication), MergeError> {
    let mut parts =
        folders.iter().map(|folder| PublishedPart::read(folder)).collect::<Result<Vec<_>, _>>()?;
    parts.sort_by_key(|part| part.experiment.first_seed);
    for pair in parts.windows(2) {
        pair[1].follows(&pair[0])?;
    }
    let [first, ..] = parts.as_slice() else { return Ok((String::new(), Publication::default())) };
    let seeds = parts.iter().map(|part| part.experiment.seeds).sum();
    let whole = Experiment { seeds, ..first.experiment.clone() };
    let name = whole.name.clone();
    let campaign = Campaign::expand([whole])?;
    let (entry, trail) = (&campaign.entries[0], joined(&parts));
    let manifest = Manifest::merged(parts.iter().map(|part| &part.manifest), &trail);
    let mut tables = Tables::default();
    parts.into_iter().for_each(|part| tables.append(part.tables));
    let mut publication = entry.publish_rows(&entry.points[0], &tables).map_err(Box::new)?;
    if manifest.git_revision.contains(", ") {
        let notice = format!("{name}: parts of several revisions: {}", manifest.git_revision);
        publication.notices.push(notice);
    }
    let folder = Path::new("results").join(&name);
    let manifest = manifest.to_yaml().map_err(|words| Box::new(PublishError::Spec(words)))?;
    publication.files.insert(folder.join("manifest.yaml"), manifest);
    put(&mut publication.files, &folder, &trail)?;
    Ok((name, publication))
}

impl PublishedPart {
    fn read(folder: &Path) -> Result<PublishedPart, MergeError> {
        let study = ExperimentSet::read(&folder.join("spec.yaml"), &[], &[])?;
        if !study.sweep.is_empty() {
            return Err(refused(folder, "a sweep", "repetitions of one experiment"));
        }
        let part = PublishedPart {
            folder: folder.to_owned(),
            experiment: study.experiment,
            manifest: Manifest::read(&folder.join("manifest.yaml"))?,
            tables: Tables::read(folder)?,
            trail: tables::read_csv(&folder.join("stages.csv"))?,
        };
        part.check_whole()?;
        Ok(part)
    }

    /// Refuses tables that a copy has left out or cut off.
    fn check_whole(&self) -> Result<(), MergeError> {
        let campaign = Campaign::expand([self.experiment.clone()])?;
        let repetitions = &campaign.entries[0].points[0].repetitions;
        let trained = || repetitions.iter().flat_map(|repetition| &repetition.trained);
        let (published, drawn) = (&self.tables.published, self.experiment.targets.drawn);
        let runs: BTreeSet<_> =
            published.tracks.iter().map(|row| (row.seed, &row.training, &row.policy)).collect();
        let reached: usize = trained().map(|cells| cells.reach.len()).sum();
        let responded: usize = trained().map(|cells| cells.response.len()).sum();
        let paced: usize = trained().map(|cells| cells.pace.len()).sum();
        let speeds = self.experiment.runs.pace.as_ref().map_or(0, |run| run.speeds.len());
        let changes = || {
            trained().filter_map(|cells| cells.repair.as_ref()).flat_map(|repair| &repair.changes)
        };
        let repair_cells: usize = changes().map(|change| change.trials.len()).sum();
        let intervals: u64 = published.cases.iter().map(|case| case.intervals).sum();
        let counts = [
            ("trials.csv", published.trials.len(), drawn * reached, "trials"),
            ("tracks.csv", runs.len(), trained().map(|cells| cells.track.len()).sum(), "runs"),
            ("responses.csv", published.responses.len(), drawn * responded, "trials"),
            ("paces.csv", published.paces.len(), speeds * paced, "laps"),
            ("repairs.csv", published.repairs.len(), changes().count(), "changes"),
            ("repair_trials.csv", published.repair_trials.len(), drawn * repair_cells, "trials"),
            (
                "discovery.csv",
                published.cases.len(),
                repetitions.iter().map(|repetition| repetition.blind.len()).sum(),
                "cases",
            ),
            ("intervals.csv", published.intervals.len(), intervals as usize, "intervals"),
        ];
        if let Some((table, found, expected, what)) =
            counts.into_iter().find(|(_, found, expected, _)| found != expected)
        {
            return Err(refused(
                &self.folder.join(table),
                &format!("{found} {what}"),
                &expected.to_string(),
            ));
        }
        let expected_seeds = self.experiment.repetitions();
        let seeds = published
            .trials
            .iter()
            .map(|row| row.seed)
            .chain(published.tracks.iter().map(|row| row.seed));
        match seeds.into_iter().find(|seed| !expected_seeds.contains(seed)) {
            Some(seed) => {
                let expected = format!("{} to {}", expected_seeds.start, expected_seeds.end - 1);
                Err(refused(&self.folder, &format!("rows of repetition {seed}"), &expected))
            }
            None => Ok(()),
        }
    }

    /// Whether it is the same experiment, continued where `before` ends.
    fn follows(&self, before: &PublishedPart) -> Result<(), MergeError> {
        let settings =
            |experiment: &Experiment| Experiment { seeds: 1, first_seed: 0, ..experiment.clone() };
        let other = before.folder.display();
        if settings(&self.experiment) != settings(&before.experiment) {
            let expected = format!("that of {other}, but for `seeds` and `first_seed`");
            return Err(refused(&self.folder, "another spec", &expected));
        }
        let (found, expected) = (self.experiment.first_seed, before.experiment.repetitions().end);
        if found != expected {
            let expected = format!("{expected}, which follows {other}");
            return Err(refused(&self.folder, &format!("repetitions from {found} on"), &expected));
        }
        Ok(())
    }
}

fn refused(place: &Path, found: &str, expected: &str) -> MergeError {
    MergeError::Part {
        place: place.to_owned(),
        found: found.to_owned(),
        expected: expected.to_owned(),
    }
}

/// The stages of all parts; those that several needed stand there once.
fn joined(parts: &[PublishedPart]) -> Vec<StageRow> {
    let mut seen = BTreeSet::new();
    let rows = parts.iter().flat_map(|part| &part.trail);
    rows.filter(|row| seen.insert((&row.stage, &row.label, &row.key))).cloned().collect()
}
