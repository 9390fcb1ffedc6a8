//! The results of a sweep: the tables of all points one below the other, with a column for each swept field, and a
//! summary of one row a point.

use super::campaign::{CampaignEntry, PointStages};
use super::metrics::Tables;
use super::outcomes::Outcomes;
use super::results::{Files, Publication, PublishError, failed};
use crate::data::TableRow;
use crate::data::rows::SweepRow;
use crate::data::tables::{Beside, to_csv_beside};
use crate::report::{Published, SweepTable, gp_sweep, reach_sweep, track_sweep};
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
        let parts: Vec<&Published> = all.iter().map(|one| &one.published).collect();
        for (name, bytes) in Published::csv_files(&parts, |counts| self.beside(counts))? {
            files.insert(folder.join(name), bytes);
        }
        let counts: Vec<usize> = summary.iter().map(Vec::len).collect();
        let swept = SweepTable { fields: self.beside(&counts), rows: summary.into_iter().flatten().collect() };
        let published = Published { sweep: swept, ..Published::default() };
        let mut notices = Vec::new();
        if !published.sweep.rows.is_empty() {
            let path = folder.join(SweepRow::TABLE.file);
            let bytes = to_csv_beside(&path, &published.sweep.fields, &published.sweep.rows)?;
            files.insert(path, bytes);
            notices = self.draw(&[FIGURE.to_owned()], &published, &folder, &mut files);
        }
        let name = &self.experiment.name;
        let others = self.experiment.figures.iter().filter(|figure| *figure != FIGURE);
        notices.extend(others.map(|figure| format!("{name}: {figure} is of one setting and not made of a sweep")));
        Ok(Publication { files, claims: Vec::new(), failed: all.iter().map(failed).sum(), notices })
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
    rows.extend(gp_sweep(&tables.published.gps));
    rows
}
