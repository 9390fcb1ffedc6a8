//! The results of a sweep: the tables of all points one below the other, with a column for each
//! swept field, a summary of one row a point, and what makes a difference.

use super::failed_cells::failed_cells;
use super::metrics::Tables;
use super::results::{Files, Publication, PublishError, draw};
use crate::data::TableRow;
use crate::data::tables::{Beside, to_csv_beside};
use crate::report::{
    Published, SweepCell, SweepTable, SweptPoint, comparisons, gp_sweep, reach_sweep,
    response_sweep, track_sweep,
};
use crate::rows::cell::CellLabel;
use crate::rows::experiment::{ComparisonRow, SweepRow};
use crate::runner::campaign::{CampaignEntry, PointStages};
use crate::runner::execute::outcomes::Outcomes;
use crate::specs::track_cells;
use std::path::Path;

/// The figure that every sweep has.
pub(super) const FIGURE: &str = "sweep";

impl CampaignEntry {
    /// Makes the files of this sweep from the results of its stages. The claims are judged at every
    /// point, and count for none of the published ones.
    pub(crate) fn publish_sweep(&self, outcomes: &Outcomes) -> Result<Publication, PublishError> {
        let mut all: Vec<Tables> = Vec::with_capacity(self.points.len());
        for point in &self.points {
            let mut tables = point.tables(outcomes);
            tables.published.claims = self.claims(point, &tables);
            all.push(tables);
        }
        let swept: Vec<SweptPoint> =
            self.points.iter().zip(&all).map(|(point, tables)| summary(point, tables)).collect();
        let folder = Path::new("results").join(&self.experiment.name);
        let mut files = Files::new();
        files.insert(folder.join("spec.yaml"), self.spec_yaml());
        let parts: Vec<&Published> = all.iter().map(|tables| &tables.published).collect();
        for (name, bytes) in Published::csv_files(&parts, |counts| self.beside(counts))? {
            files.insert(folder.join(name), bytes);
        }
        files.extend(self.comparisons(&swept, &folder)?);
        let counts: Vec<usize> = swept.iter().map(|point| point.cells.len()).collect();
        let rows = swept.into_iter().flat_map(|point| point.cells).map(|cell| cell.row).collect();
        let published = Published {
            sweep: SweepTable { fields: self.beside(&counts), rows },
            ..Published::default()
        };
        let mut notices = Vec::new();
        if !published.sweep.rows.is_empty() {
            let path = folder.join(SweepRow::TABLE.file);
            let bytes = to_csv_beside(&path, &published.sweep.fields, &published.sweep.rows)?;
            files.insert(path, bytes);
            let name = &self.experiment.name;
            notices = draw(name, &[FIGURE.to_owned()], &published, &mut files);
        }
        let mut remarks = Vec::new();
        self.tell_range_ends(&parts, &mut notices, &mut remarks);
        let name = &self.experiment.name;
        let others = self.experiment.figures.iter().filter(|figure| *figure != FIGURE);
        notices.extend(others.map(|figure| {
            format!("{name}: {figure} shows one setting; it is not drawn for a sweep")
        }));
        Ok(Publication {
            files,
            claims: Vec::new(),
            failed_cells: parts.iter().flat_map(|part| failed_cells(part)).collect(),
            failed: all.iter().map(|tables| tables.published.failed()).sum(),
            notices,
            remarks,
        })
    }

    /// The table of what makes a difference; none where there is nothing to compare.
    fn comparisons(&self, swept: &[SweptPoint], folder: &Path) -> Result<Files, PublishError> {
        let fields: Vec<(String, Vec<String>)> =
            self.sweep.iter().map(|field| (field.name.clone(), field.values.clone())).collect();
        let compared = comparisons(&fields, swept);
        let mut files = Files::new();
        if !compared.is_empty() {
            let mut counts = vec![0; swept.len()];
            compared.iter().for_each(|(point, _)| counts[*point] += 1);
            let rows: Vec<ComparisonRow> = compared.into_iter().map(|(_, row)| row).collect();
            let path = folder.join(ComparisonRow::TABLE.file);
            let bytes = to_csv_beside(&path, &self.beside(&counts), &rows)?;
            files.insert(path, bytes);
        }
        Ok(files)
    }

    /// The columns of the swept fields beside tables with so many rows at each point.
    fn beside(&self, counts: &[usize]) -> Vec<Beside> {
        let column = |index: usize| {
            let value = |point: &PointStages| self.sweep[index].values[point.values[index]].clone();
            let cells = self
                .points
                .iter()
                .zip(counts)
                .flat_map(|(point, &count)| std::iter::repeat_n(value(point), count));
            (self.sweep[index].name.clone(), cells.collect())
        };
        (0..self.sweep.len()).map(column).collect()
    }
}

/// What one point has of the summary.
fn summary(point: &PointStages, tables: &Tables) -> SweptPoint {
    let mut cells: Vec<SweepCell> = reach_sweep(&tables.published.trials);
    cells.extend(response_sweep(&tables.published.responses));
    if let Some(track) = &point.experiment.runs.track {
        let tracked = track_cells(&point.experiment);
        let cell = |policy: &str| {
            let without_cell = || CellLabel {
                policy: policy.to_owned(),
                mode: track.mode.clone(),
                ..CellLabel::default()
            };
            tracked.iter().find(|cell| cell.policy == policy).cloned().unwrap_or_else(without_cell)
        };
        cells.extend(track_sweep(&tables.runs, cell));
    }
    cells.extend(gp_sweep(&tables.published.gps));
    SweptPoint { values: point.values.clone(), cells }
}
