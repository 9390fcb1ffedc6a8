//! From published rows to one value per seed.

use crate::data::rows::{GapRow, GpRow, NetworkRow, TrackRow, TrialRow};
use crate::math::summary::{mean, standard_deviation};
use crate::specs::{Axis, Metric, ReachCell};

/// All rows of one experiment.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    /// Goal reaching.
    pub trials: Vec<TrialRow>,
    /// Path tracking.
    pub track: Vec<TrackRow>,
    /// Model against robot.
    pub gap: Vec<GapRow>,
    /// Networks.
    pub networks: Vec<NetworkRow>,
    /// Gaussian processes.
    pub gps: Vec<GpRow>,
}

/// The metric for one seed and training; `None` where the rows do not tell (no such rows, none without failure).
pub(super) fn value(tables: &Tables, metric: &Metric, seed: u64, training: &str) -> Option<f64> {
    let found = match metric {
        Metric::ReachMean(cell) => mean(&reach_errors_m(tables, cell, seed, training)),
        Metric::ReachSd(cell) => standard_deviation(&reach_errors_m(tables, cell, seed, training)),
        Metric::NetworkMae { network, points } => {
            let ours = |row: &&NetworkRow| row.seed == seed && row.training == training && row.network == *network;
            let row =
                tables.networks.iter().filter(ours).find(|row| points.is_none_or(|points| points == row.points))?;
            row.validation_mae_m
        }
        Metric::GpError { points } => {
            tables.gps.iter().find(|row| row.seed == seed && row.points == *points)?.cross_validation_mae_m
        }
        Metric::TrackMean { policy } => mean(&track_errors_m(tables, policy, seed, training)?),
        Metric::TrackSwing { policy } => mean(&swings(&track_errors_m(tables, policy, seed, training)?)),
        Metric::TrackTime { policy } => track(tables, policy, seed, training).last()?.time_s,
        Metric::TrackStart { policy } => {
            track(tables, policy, seed, training).take_while(|row| row.path_point == 0).last()?.error_m
        }
        Metric::GapRms { axis } => gap_rms_m(tables, *axis, seed),
    };
    found.is_finite().then_some(found)
}

/// Errors of the trials that ended without failure, metres.
fn reach_errors_m(tables: &Tables, cell: &ReachCell, seed: u64, training: &str) -> Vec<f64> {
    let ours = |row: &&TrialRow| {
        row.seed == seed
            && row.training == training
            && row.policy == cell.policy
            && row.mode == cell.mode
            && cell.gp_points.is_none_or(|points| points == row.gp_points)
            && cell.real_points.is_none_or(|points| points == row.real_points)
            && row.error_m.is_finite()
    };
    tables.trials.iter().filter(ours).map(|row| row.error_m).collect()
}

fn track<'a>(tables: &'a Tables, policy: &str, seed: u64, training: &str) -> impl Iterator<Item = &'a TrackRow> {
    let ours = move |row: &&TrackRow| row.seed == seed && row.training == training && row.policy == policy;
    tables.track.iter().filter(ours)
}

/// Tracking errors step by step, metres; `None` when the run failed on its way.
fn track_errors_m(tables: &Tables, policy: &str, seed: u64, training: &str) -> Option<Vec<f64>> {
    let errors: Vec<f64> = track(tables, policy, seed, training).map(|row| row.error_m).collect();
    errors.iter().all(|error| error.is_finite()).then_some(errors)
}

/// Differences between successive extremes of a series.
fn swings(series: &[f64]) -> Vec<f64> {
    let turns = series.windows(3).filter(|three| (three[1] - three[0]) * (three[2] - three[1]) < 0.0);
    let extremes: Vec<f64> = turns.map(|three| three[1]).collect();
    extremes.windows(2).map(|two| (two[1] - two[0]).abs()).collect()
}

fn gap_rms_m(tables: &Tables, axis: Axis, seed: u64) -> f64 {
    let difference = |row: &GapRow| match axis {
        Axis::X => row.sim_x_m - row.real_x_m,
        Axis::Y => row.sim_y_m - row.real_y_m,
        Axis::Z => row.sim_z_m - row.real_z_m,
    };
    let squares: Vec<f64> =
        tables.gap.iter().filter(|row| row.seed == seed).map(|row| difference(row).powi(2)).collect();
    mean(&squares).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swings_are_measured_between_turning_points() {
        assert_eq!(swings(&[0.0, 3.0, 1.0, 1.5, 4.0, 2.0]), [2.0, 3.0]);
        assert!(swings(&[1.0, 2.0, 3.0]).is_empty());
    }
}
