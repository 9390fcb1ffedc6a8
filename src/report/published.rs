//! The rows that an experiment publishes, each kind in a file of its own under `results/<experiment>/`.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::sweep_rows::SweepTable;
use crate::data::findings::{CaseRow, IntervalRow};
use crate::data::rows::{ClaimRow, GapRow, PeerRow, ScalingRow, TrackRow, TrialRow, WaypointRow, WorkspaceRow};
use crate::data::{DataError, tables, write_atomic};

/// The rows that a figure may ask for; an experiment fills in those it has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Published {
    /// Goal-reaching trials (`trials.csv`).
    pub trials: Vec<TrialRow>,
    /// Path tracking steps (`tracks.csv`).
    pub tracks: Vec<TrackRow>,
    /// Points that the path runs through (`waypoints.csv`).
    pub waypoints: Vec<WaypointRow>,
    /// Points of the real workspace behind the path (`workspace.csv`).
    pub workspace: Vec<WorkspaceRow>,
    /// Simulated and measured tips (`gap.csv`).
    pub gaps: Vec<GapRow>,
    /// Claims (`claims.csv`).
    pub claims: Vec<ClaimRow>,
    /// Points of a sweep (`sweep.csv`).
    pub sweep: SweepTable,
    /// Simulators beside each other (`work_precision.csv`).
    pub peers: Vec<PeerRow>,
    /// Blind cases of discovery (`discovery.csv`).
    pub cases: Vec<CaseRow>,
    /// Their intervals (`intervals.csv`).
    pub intervals: Vec<IntervalRow>,
    /// Campaigns on more and more workers (`scaling.csv`).
    pub scaling: Vec<ScalingRow>,
}

impl Published {
    /// Reads what a folder of results has; kinds whose file is not there stay empty.
    ///
    /// # Errors
    /// [`DataError`] for the first file that is there and cannot be read.
    pub fn read(folder: &Path) -> Result<Published, DataError> {
        let sweep = swept(folder)?;
        if !sweep.rows.is_empty() {
            // The other tables are those of all its points: no figure is made of them together.
            return Ok(Published { sweep, ..Published::default() });
        }
        Ok(Published {
            trials: published_rows(folder, "trials.csv")?,
            tracks: published_rows(folder, "tracks.csv")?,
            waypoints: published_rows(folder, "waypoints.csv")?,
            workspace: published_rows(folder, "workspace.csv")?,
            gaps: published_rows(folder, "gap.csv")?,
            claims: published_rows(folder, "claims.csv")?,
            sweep,
            peers: published_rows(folder, "work_precision.csv")?,
            cases: published_rows(folder, "discovery.csv")?,
            intervals: published_rows(folder, "intervals.csv")?,
            scaling: published_rows(folder, "scaling.csv")?,
        })
    }

    /// Writes every kind that has rows into a folder of results and gives the rows back as they stand there, rounded:
    /// a figure drawn from them can be drawn again from the files, byte for byte.
    ///
    /// # Errors
    /// [`DataError`] for the first file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Published, DataError> {
        write(folder, "trials.csv", &self.trials)?;
        write(folder, "tracks.csv", &self.tracks)?;
        write(folder, "waypoints.csv", &self.waypoints)?;
        write(folder, "workspace.csv", &self.workspace)?;
        write(folder, "gap.csv", &self.gaps)?;
        write(folder, "claims.csv", &self.claims)?;
        if !self.sweep.rows.is_empty() {
            let path = folder.join("sweep.csv");
            write_atomic(&path, &tables::to_csv_beside(&path, &self.sweep.fields, &self.sweep.rows)?)?;
        }
        write(folder, "work_precision.csv", &self.peers)?;
        write(folder, "discovery.csv", &self.cases)?;
        write(folder, "intervals.csv", &self.intervals)?;
        write(folder, "scaling.csv", &self.scaling)?;
        Published::read(folder)
    }
}

/// The rows of one table of a folder of results; none where it is not there.
///
/// # Errors
/// [`DataError`] for a file that is there and cannot be read.
pub fn published_rows<R: DeserializeOwned>(folder: &Path, name: &str) -> Result<Vec<R>, DataError> {
    let path = folder.join(name);
    if path.exists() { tables::read_csv(&path) } else { Ok(Vec::new()) }
}

/// The summary of a sweep: what is swept stands in the columns with a dot in their names.
fn swept(folder: &Path) -> Result<SweepTable, DataError> {
    let path = folder.join("sweep.csv");
    if !path.exists() {
        return Ok(SweepTable::default());
    }
    let (fields, rows) = tables::read_csv_beside(&path, |name| name.contains('.'))?;
    Ok(SweepTable { fields, rows })
}

fn write<R: Serialize>(folder: &Path, name: &str, rows: &[R]) -> Result<(), DataError> {
    if rows.is_empty() { Ok(()) } else { tables::write_csv(&folder.join(name), rows) }
}
