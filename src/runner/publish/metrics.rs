//! From published rows to one value per seed.

use crate::data::DataError;
use crate::math::summary::{mean, standard_deviation};
use crate::report::{Published, track_summary};
use crate::rows::experiment::{GapRow, GpRow, NetworkRow, TrackSummaryRow, TrialRow};
use crate::runner::campaign::ANY_TRAINING;
use crate::specs::{ClaimMetric, FrameAxis, ReachCell};
use std::path::Path;

/// All rows of one experiment.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// What is published.
    pub published: Published,
    /// Tracking runs, summarised.
    pub runs: Vec<TrackSummaryRow>,
}

impl From<Published> for Tables {
    fn from(published: Published) -> Tables {
        Tables { runs: track_summary(&published.tracks), published }
    }
}

impl Tables {
    /// Reads what a folder of results has of one experiment.
    ///
    /// # Errors
    /// [`DataError`] for the first file that is there and cannot be read.
    pub(crate) fn read(folder: &Path) -> Result<Tables, DataError> {
        Published::read(folder).map(Tables::from)
    }

    /// These rows as [`Tables::read`] gives them back once they are published, but for their
    /// claims, which are made of them: what is made of them can be made again.
    ///
    /// # Errors
    /// [`DataError::Write`] for rows that make no table.
    pub(crate) fn as_published(&self, folder: &Path) -> Result<Tables, DataError> {
        let (claims, robot_claims) = (Vec::new(), Vec::new());
        Ok(Tables::from(Published { claims, robot_claims, ..self.published.rounded(folder)? }))
    }

    /// Adds the rows of further repetitions, but for their claims, which are of all repetitions
    /// together.
    pub(crate) fn append(&mut self, other: Tables) {
        self.published.append(Published {
            claims: Vec::new(),
            robot_claims: Vec::new(),
            ..other.published
        });
        self.runs.extend(other.runs);
    }
}

/// The metric for one seed and training; `None` where the rows do not tell (no such rows, none
/// without failure).
pub(crate) fn value(
    tables: &Tables,
    metric: &ClaimMetric,
    seed: u64,
    training: &str,
) -> Option<f64> {
    let number = match metric {
        ClaimMetric::ReachMean(cell) => mean(&reach_errors_m(tables, cell, seed, training)),
        ClaimMetric::ReachSd(cell) => {
            standard_deviation(&reach_errors_m(tables, cell, seed, training))
        }
        ClaimMetric::NetworkMae { network, points } => {
            let matches = |row: &&NetworkRow| {
                row.seed == seed && row.training == training && row.network == *network
            };
            let row = tables
                .published
                .networks
                .iter()
                .filter(matches)
                .find(|row| points.is_none_or(|points| points == row.points))?;
            row.validation_mae_m
        }
        ClaimMetric::GpError { points } => {
            let matches = |row: &&GpRow| row.training == training || row.training == ANY_TRAINING;
            let of_size =
                |row: &&GpRow| row.seed == seed && row.score.points == *points && matches(row);
            tables.published.gps.iter().find(of_size)?.score.cross_validation_mae_m
        }
        ClaimMetric::TrackMean { policy } => run(tables, policy, seed, training)?.mean_error_m,
        ClaimMetric::TrackOscillation { policy } => {
            run(tables, policy, seed, training)?.oscillation_m
        }
        ClaimMetric::TrackTime { policy } => run(tables, policy, seed, training)?.completion_time_s,
        ClaimMetric::TrackStart { policy } => run(tables, policy, seed, training)?.start_error_m,
        ClaimMetric::GapRms { axis } => gap_rms_m(tables, *axis, seed),
    };
    number.is_finite().then_some(number)
}

/// Errors of the trials that ended without failure, metres.
fn reach_errors_m(tables: &Tables, cell: &ReachCell, seed: u64, training: &str) -> Vec<f64> {
    let matches = |row: &&TrialRow| {
        row.seed == seed
            && row.training == training
            && cell.includes(&row.cell)
            && row.status.is_ok()
            && row.error_m.is_finite()
    };
    tables.published.trials.iter().filter(matches).map(|row| row.error_m).collect()
}

/// The tracking run that did not fail.
fn run<'a>(
    tables: &'a Tables,
    policy: &str,
    seed: u64,
    training: &str,
) -> Option<&'a TrackSummaryRow> {
    let matches = |row: &&TrackSummaryRow| {
        row.seed == seed && row.training == training && row.policy == policy
    };
    tables.runs.iter().find(matches).filter(|row| row.status.is_ok())
}

fn gap_rms_m(tables: &Tables, axis: FrameAxis, seed: u64) -> f64 {
    let difference = |row: &GapRow| match axis {
        FrameAxis::X => row.gap.sim_x_m - row.gap.real_x_m,
        FrameAxis::Y => row.gap.sim_y_m - row.gap.real_y_m,
        FrameAxis::Z => row.gap.sim_z_m - row.gap.real_z_m,
    };
    let squares: Vec<f64> = tables
        .published
        .gaps
        .iter()
        .filter(|row| row.seed == seed)
        .map(|row| difference(row).powi(2))
        .collect();
    mean(&squares).sqrt()
}
