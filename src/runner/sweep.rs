//! The results of a sweep: the tables of all points one below the other, with a column for each swept field, and a
//! summary of one row a point.

use super::campaign::{CampaignEntry, PointStages};
use super::metrics::Tables;
use super::outcomes::Outcomes;
use super::results::{Files, Publication, PublishError, failed};
use crate::data::DataError;
use crate::data::rows::SweepRow;
use crate::data::tables::{Beside, to_csv_beside};
use crate::report::{Published, SweepTable, gp_sweep, reach_sweep, track_sweep};
use serde::Serialize;
use std::path::Path;

/// The figure that every sweep has.
const FIGURE: &str = "sweep";

impl CampaignEntry {
    /// Makes the files of this sweep from the results of its stages. The claims are judged at every point, and count for
    /// none of the published ones.
    pub(super) fn publish_sweep(&self, outcomes: &Outcomes) -> Result<Publication, PublishError> {
        let mut all: Vec<Tables> = Vec::with_capacity(self.points.len());
        for point in &self.points {
            let mut tables = point.tables(outcomes);
            tables.published.claims = self.claims(point, &tables);
            all.push(tables);
        }
        let summary: Vec<Vec<SweepRow>> = self.points.iter().zip(&all).map(|(point, one)| rows(point, one)).collect();
        let folder = Path::new("results").join(&self.experiment.name);
        let mut files = Files::new();
        files.insert(folder.join("spec.yaml"), self.spec_yaml()?);
        self.put(&mut files, &folder.join("sweep.csv"), summary.iter())?;
        self.put(&mut files, &folder.join("gap.csv"), all.iter().map(|one| &one.published.gaps))?;
        self.put(&mut files, &folder.join("gp.csv"), all.iter().map(|one| &one.gps))?;
        self.put(&mut files, &folder.join("networks.csv"), all.iter().map(|one| &one.networks))?;
        self.put(&mut files, &folder.join("trials.csv"), all.iter().map(|one| &one.published.trials))?;
        self.put(&mut files, &folder.join("waypoints.csv"), all.iter().map(|one| &one.published.waypoints))?;
        self.put(&mut files, &folder.join("tracks.csv"), all.iter().map(|one| &one.published.tracks))?;
        self.put(&mut files, &folder.join("discovery.csv"), all.iter().map(|one| &one.published.cases))?;
        self.put(&mut files, &folder.join("intervals.csv"), all.iter().map(|one| &one.published.intervals))?;
        self.put(&mut files, &folder.join("claims.csv"), all.iter().map(|one| &one.published.claims))?;
        let counts: Vec<usize> = summary.iter().map(Vec::len).collect();
        let swept = SweepTable { fields: self.beside(&counts), rows: summary.into_iter().flatten().collect() };
        let published = Published { sweep: swept, ..Published::default() };
        let mut notices = Vec::new();
        if !published.sweep.rows.is_empty() {
            notices = self.draw(&[FIGURE.to_owned()], &published, &folder, &mut files);
        }
        let name = &self.experiment.name;
        let others = self.experiment.figures.iter().filter(|figure| *figure != FIGURE);
        notices.extend(others.map(|figure| format!("{name}: {figure} is of one setting and not made of a sweep")));
        Ok(Publication { files, claims: Vec::new(), failed: all.iter().map(failed).sum(), notices })
    }

    /// Adds the rows of all points as one table, unless there are none.
    fn put<'a, R: Serialize + Clone + 'a>(
        &self,
        files: &mut Files,
        path: &Path,
        points: impl Iterator<Item = &'a Vec<R>>,
    ) -> Result<(), DataError> {
        let points: Vec<&Vec<R>> = points.collect();
        let counts: Vec<usize> = points.iter().map(|rows| rows.len()).collect();
        let rows: Vec<R> = points.into_iter().flatten().cloned().collect();
        if !rows.is_empty() {
            files.insert(path.to_owned(), to_csv_beside(path, &self.beside(&counts), &rows)?);
        }
        Ok(())
    }

    /// The columns of the swept fields beside tables with so many rows at each point.
    fn beside(&self, counts: &[usize]) -> Vec<Beside> {
        let column = |index: usize| {
            let value = |point: &PointStages| self.sweep[index].values[point.values[index]].clone();
            let cells =
                self.points.iter().zip(counts).flat_map(|(point, &count)| std::iter::repeat_n(value(point), count));
            (self.sweep[index].name.clone(), cells.collect())
        };
        (0..self.sweep.len()).map(column).collect()
    }
}

/// What one point has of the summary.
fn rows(point: &PointStages, tables: &Tables) -> Vec<SweepRow> {
    let mut rows = reach_sweep(&tables.published.trials);
    if let Some(track) = &point.experiment.runs.track {
        let sizes = crate::specs::track_cells(&point.experiment);
        let sizes = |policy: &str| {
            let cell = sizes.iter().find(|cell| cell.policy == policy);
            cell.map_or([0, 0], |cell| [cell.gp_points as u64, cell.real_points as u64])
        };
        rows.extend(track_sweep(&tables.runs, &track.mode, sizes));
    }
    rows.extend(gp_sweep(&tables.gps));
    rows
}
