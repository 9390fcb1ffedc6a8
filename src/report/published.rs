//! The rows that an experiment publishes, each kind in a file of its own under
//! `results/<experiment>/`.

use std::path::Path;

use super::paper::summarise::reach_summary;
use super::style::{self, PAPER_TRAINING};
use super::sweep::rows::SweepTable;
use crate::data::findings::{CaseRow, IntervalRow};
use crate::data::tables::{Beside, as_published, to_csv_beside};
use crate::data::{DataError, TableRow, packed, tables, write_atomic};
use crate::policies::OutsidePolicies;
use crate::rows::experiment::{
    ClaimRow, GapRow, GpCoverageRow, GpLeaveOneOutRow, GpRow, NetworkRow, PeerRow, ReachSummaryRow,
    ScalingRow, SweepRow, TrackRow, TrialRow, WaypointRow, WorkspaceRow,
};
use crate::rows::learning_peers::LearningPeerRow;
use crate::rows::population::{PopulationRow, RobotClaimRow, RobotRow};
use crate::rows::repairs::{IdentificationRow, MonitorRow, RepairRow, RepairTrialRow};
use crate::rows::responses::{PaceRow, ResponseRow};

/// What figures know of an experiment beside its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureContext {
    /// The policies from outside.
    pub outside: OutsidePolicies,
    /// Whether the robot is the paper's, so that the paper's numbers stand beside its own.
    pub is_paper_robot: bool,
}

impl Default for FigureContext {
    fn default() -> Self {
        FigureContext { outside: OutsidePolicies::new(), is_paper_robot: true }
    }
}

macro_rules! published {
    ($($(#[doc = $about:literal])+ $field:ident: $row:ty,)*) => {
        /// The rows that a figure may ask for; an experiment fills in those it has.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Published {
            $($(#[doc = $about])+ pub $field: Vec<$row>,)*
            /// Points of a sweep (`sweep.csv`).
            pub sweep: SweepTable,
            /// Goal reaching in summary (`summary.csv`), where the trials of many robots are not
            /// published.
            pub reached: Vec<ReachSummaryRow>,
            /// Errors over these robots (`population.csv`), there too.
            pub robot_errors: Vec<PopulationRow>,
            /// What the rows do not say of the experiment.
            pub context: FigureContext,
        }

        impl Published {
            fn read_tables(folder: &Path) -> Result<Published, DataError> {
                Ok(Published { $($field: published_rows(folder)?,)* ..Published::default() })
            }

            /// These rows as [`Published::read`] gives them back once they are published.
            ///
            /// # Errors
            /// [`DataError::Write`] for rows that make no table.
            pub fn rounded(&self, folder: &Path) -> Result<Published, DataError> {
                Ok(Published {
                    $($field: as_published(&folder.join(<$row>::TABLE.file), &self.$field)?,)*
                    sweep: self.sweep.clone(),
                    reached: self.reached.clone(),
                    robot_errors: self.robot_errors.clone(),
                    context: self.context.clone(),
                })
            }

            /// Rows that stand for something that failed; of a tracking run it is the last.
            pub fn failed(&self) -> usize {
                0 $(+ self.$field.iter().filter(|row| row.failed()).count())*
            }

            /// Adds the rows of further repetitions.
            pub fn append(&mut self, other: Published) {
                $(self.$field.extend(other.$field);)*
            }

            /// The bytes of every table that has rows, by file name: the rows of `parts` one below
            /// the other, and beside them the columns that `beside` gives for so many rows of each
            /// part.
            ///
            /// # Errors
            /// [`DataError::Write`] for rows that make no table.
            pub fn csv_files(
                parts: &[&Published],
                beside: impl Fn(&[usize]) -> Vec<Beside>,
            ) -> Result<Vec<(&'static str, Vec<u8>)>, DataError> {
                let mut files = Vec::new();
                $(
                    let rows: Vec<&Vec<$row>> = parts.iter().map(|part| &part.$field).collect();
                    files.extend(csv_file(&rows, &beside)?);
                )*
                Ok(files)
            }
        }
    };
}

published! {
    /// Goal-reaching trials.
    trials: TrialRow,
    /// Path tracking steps.
    tracks: TrackRow,
    /// Responses to targets.
    responses: ResponseRow,
    /// Laps of the path in time.
    paces: PaceRow,
    /// What models lack of robots as they were built.
    identifications: IdentificationRow,
    /// Monitors of robots at work.
    monitors: MonitorRow,
    /// Changes of robots, noticed and told.
    repairs: RepairRow,
    /// Effects of robots that differ from repetition to repetition.
    robots: RobotRow,
    /// On how many of them claims hold.
    robot_claims: RobotClaimRow,
    /// Goal-reaching trials before and after changes.
    repair_trials: RepairTrialRow,
    /// Points that the path runs through.
    waypoints: WaypointRow,
    /// Points of the real workspace behind the path.
    workspace: WorkspaceRow,
    /// Simulated and measured tips.
    gaps: GapRow,
    /// Trained networks.
    networks: NetworkRow,
    /// Gaussian processes.
    gps: GpRow,
    /// What intervals of Gaussian processes cover.
    gp_coverages: GpCoverageRow,
    /// Points of Gaussian processes that are left out.
    gp_left_out: GpLeaveOneOutRow,
    /// Claims.
    claims: ClaimRow,
    /// Simulators beside each other.
    peers: PeerRow,
    /// Learning beside other packages.
    learning_peers: LearningPeerRow,
    /// Blind cases of discovery.
    cases: CaseRow,
    /// Their intervals.
    intervals: IntervalRow,
    /// Campaigns on more and more workers.
    scaling: ScalingRow,
}

impl Published {
    /// What a way of training means, in words, for networks that reached where it ends.
    pub(super) fn training_label(&self, training: &str) -> String {
        let networks = self.networks.iter().filter(|network| network.training == training);
        let beyond = |network: &NetworkRow| network.validation_mae_m > network.paper_mae_m;
        if training == PAPER_TRAINING && networks.clone().any(beyond) {
            return "networks that did not reach the paper’s errors".to_owned();
        }
        style::training_label(training)
    }

    /// [`reach_summary`] of these trials, or what is published in their place; with the paper's
    /// numbers where the robot is the paper's.
    pub(super) fn reach_summary(&self, trials: &[TrialRow]) -> Vec<ReachSummaryRow> {
        let mut summary =
            if trials.is_empty() { self.reached.clone() } else { reach_summary(trials) };
        if !self.context.is_paper_robot {
            for row in &mut summary {
                (row.paper_mean_m, row.paper_sd_m) = (f64::NAN, f64::NAN);
            }
        }
        summary
    }

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
        let tables = Published::read_tables(folder)?;
        if tables.robots.is_empty() || !tables.trials.is_empty() {
            return Ok(tables);
        }
        let (reached, robot_errors) = (published_rows(folder)?, published_rows(folder)?);
        Ok(Published { reached, robot_errors, ..tables })
    }

    /// Writes every kind that has rows into a folder of results and gives the rows back as they
    /// stand there, rounded: a figure drawn from them can be drawn again from the files, byte for
    /// byte.
    ///
    /// # Errors
    /// [`DataError`] for the first file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Published, DataError> {
        for (name, bytes) in Published::csv_files(&[self], |_| Vec::new())? {
            write_atomic(&folder.join(name), &bytes)?;
        }
        if !self.sweep.rows.is_empty() {
            let path = folder.join(SweepRow::TABLE.file);
            write_atomic(&path, &to_csv_beside(&path, &self.sweep.fields, &self.sweep.rows)?)?;
        }
        Published::read(folder)
    }
}

/// The CSV of the rows of all parts, unless there are none.
fn csv_file<R: TableRow>(
    parts: &[&Vec<R>],
    beside: &impl Fn(&[usize]) -> Vec<Beside>,
) -> Result<Option<(&'static str, Vec<u8>)>, DataError> {
    let counts: Vec<usize> = parts.iter().map(|rows| rows.len()).collect();
    let rows: Vec<R> = parts.iter().copied().flatten().cloned().collect();
    if rows.is_empty() {
        return Ok(None);
    }
    let file = R::TABLE.file;
    Ok(Some((file, to_csv_beside(Path::new(file), &beside(&counts), &rows)?)))
}

/// The rows of one table of a folder of results; none where it is not there.
///
/// # Errors
/// [`DataError`] for a file that is there and cannot be read.
pub fn published_rows<R: TableRow>(folder: &Path) -> Result<Vec<R>, DataError> {
    let path = folder.join(R::TABLE.file);
    if packed::stored(&path).is_some() { tables::read_csv(&path) } else { Ok(Vec::new()) }
}

/// The summary of a sweep: what is swept stands in the columns with a dot in their names.
fn swept(folder: &Path) -> Result<SweepTable, DataError> {
    let path = folder.join(SweepRow::TABLE.file);
    if !path.exists() {
        return Ok(SweepTable::default());
    }
    let (fields, rows) = tables::read_csv_beside(&path, |name| name.contains('.'))?;
    Ok(SweepTable { fields, rows })
}
