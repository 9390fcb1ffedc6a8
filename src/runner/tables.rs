//! Stage results to published rows: labels filled in, failures turned into rows, everything in a fixed order.

use super::campaign::{PointStages, TrainedCells};
use super::graph::Failure;
use super::metrics::Tables;
use super::outcomes::Outcomes;
use super::repair_tables;
use crate::benchmark::{DrawnEffect, ScoredCase};
use crate::data::population::RobotRow;
use crate::data::responses::{PaceRow, ResponseRow};
use crate::data::rows::{GpCoverageRow, GpLeaveOneOutRow, GpRow, NetworkRow, TrackRow, TrialRow, WaypointRow};
use crate::learn::networks::Trained;
use crate::policies::{NetworkDescription, TrainingData};
use crate::report::track_summary;
use crate::specs::{Experiment, TrialCell};

pub(super) fn assemble(point: &PointStages, outcomes: &Outcomes) -> Tables {
    let mut tables = Tables::default();
    for one in &point.repetitions {
        let seed = one.seed;
        tables.published.robots.extend(one.robot.iter().flat_map(|effect| robot_rows(seed, effect)));
        if let Some(Ok(rows)) = one.gap.map(|stage| outcomes.get(stage)) {
            tables.published.gaps.extend(rows.iter().cloned().map(|mut row| {
                row.seed = seed;
                row
            }));
        }
        if let Some(Ok(points)) = one.waypoints.map(|stage| outcomes.get(stage)) {
            let row = |(waypoint, &[x_m, y_m, z_m]): (usize, &[f64; 3])| WaypointRow {
                seed,
                waypoint: waypoint as u64,
                x_m,
                y_m,
                z_m,
            };
            tables.published.waypoints.extend(points.iter().enumerate().map(row));
        }
        let gps = one.gps.iter().filter_map(|(training, stage)| Some((training, outcomes.get(*stage).ok()?)));
        tables.published.gps.extend(gps.map(|(training, row)| GpRow {
            seed,
            training: training.clone(),
            ..row.clone()
        }));
        for (training, stage) in &one.gp_coverages {
            let rows = outcomes.get(*stage).into_iter().flatten();
            let label = |row: &GpCoverageRow| GpCoverageRow { seed, training: training.clone(), ..row.clone() };
            tables.published.gp_coverages.extend(rows.map(label));
        }
        for (training, stage) in &one.gp_left_out {
            let rows = outcomes.get(*stage).into_iter().flatten();
            let label = |row: &GpLeaveOneOutRow| GpLeaveOneOutRow { seed, training: training.clone(), ..row.clone() };
            tables.published.gp_left_out.extend(rows.map(label));
        }
        for ScoredCase { row, intervals } in one.blind.iter().map(|case| case.scored(outcomes)) {
            tables.published.cases.push(row);
            tables.published.intervals.extend(intervals);
        }
        for cells in &one.trained {
            trained(&mut tables, &point.experiment, seed, cells, outcomes);
        }
    }
    tables.runs = track_summary(&tables.published.tracks);
    tables
}

/// The parameters of an effect that the robot of a repetition has.
fn robot_rows(seed: u64, effect: &DrawnEffect) -> impl Iterator<Item = RobotRow> {
    effect.card.parameters.iter().zip(&effect.values).map(move |(parameter, &value)| RobotRow {
        seed,
        effect: effect.card.name.to_owned(),
        strength: effect.strength,
        parameter: parameter.name.to_owned(),
        value,
        unit: parameter.unit.to_owned(),
    })
}

/// Rows of one seed and training. Seeds ascend, trainings and cells are in the order of their expansion.
fn trained(tables: &mut Tables, experiment: &Experiment, seed: u64, cells: &TrainedCells, outcomes: &Outcomes) {
    let training = &cells.training;
    for (network, points, stage) in &cells.networks {
        if let Ok(trained) = outcomes.get(*stage) {
            tables.published.networks.push(network_row(seed, training, network, *points, trained, experiment));
        }
    }
    for (cell, stage) in &cells.reach {
        let failed = |failure: Failure| failed_trials(cell, experiment.targets.drawn, &failure);
        let rows = outcomes.get(*stage).map_or_else(failed, Clone::clone);
        tables.published.trials.extend(rows.into_iter().map(|row| TrialRow {
            seed,
            training: training.clone(),
            mode: cell.mode.clone(),
            gp_points: cell.gp_points as u64,
            real_points: cell.real_points as u64,
            ..row
        }));
    }
    for (cell, stage) in &cells.track {
        let rows = outcomes.get(*stage).map_or_else(|failure| vec![failed_track(cell, &failure)], Clone::clone);
        let label = |row| TrackRow { seed, training: training.clone(), ..row };
        tables.published.tracks.extend(rows.into_iter().map(label));
    }
    fixed_duration(tables, experiment, seed, cells, outcomes);
    if let Some(repair) = &cells.repair {
        repair_tables::add(tables, (seed, training), repair, experiment.targets.drawn, outcomes);
    }
}

/// Responses and laps of one seed and training.
fn fixed_duration(tables: &mut Tables, experiment: &Experiment, seed: u64, cells: &TrainedCells, outcomes: &Outcomes) {
    let training = &cells.training;
    for (cell, stage) in &cells.response {
        let failed = |failure: Failure| {
            (0..experiment.targets.drawn as u64)
                .map(|draw| ResponseRow::unmeasured(draw, failure.to_string()))
                .collect()
        };
        let rows: Vec<ResponseRow> = outcomes.get(*stage).map_or_else(failed, Clone::clone);
        tables.published.responses.extend(rows.into_iter().map(|row| ResponseRow {
            seed,
            training: training.clone(),
            policy: cell.policy.clone(),
            mode: cell.mode.clone(),
            gp_points: cell.gp_points as u64,
            real_points: cell.real_points as u64,
            ..row
        }));
    }
    let laps = experiment.runs.pace.iter().flat_map(|run| run.speeds.iter().map(|speed| (*speed, run.lap_s / speed)));
    for (cell, stage) in &cells.pace {
        let failed = |failure: Failure| {
            laps.clone().map(|(speed, lap_s)| PaceRow::unmeasured(speed, lap_s, failure.to_string())).collect()
        };
        let rows: Vec<PaceRow> = outcomes.get(*stage).map_or_else(failed, Clone::clone);
        tables.published.paces.extend(rows.into_iter().map(|row| PaceRow {
            seed,
            training: training.clone(),
            policy: cell.policy.clone(),
            mode: cell.mode.clone(),
            gp_points: cell.gp_points as u64,
            real_points: cell.real_points as u64,
            ..row
        }));
    }
}

fn network_row(
    seed: u64,
    training: &str,
    network: &NetworkDescription,
    points: usize,
    trained: &Trained,
    experiment: &Experiment,
) -> NetworkRow {
    let points = match network.data {
        TrainingData::Simulated => experiment.explore.points,
        TrainingData::Randomised => experiment.policies.dagger.samples(),
        TrainingData::Real | TrainingData::Generated => points,
    };
    NetworkRow {
        seed,
        training: training.to_owned(),
        network: network.name.to_owned(),
        points: points as u64,
        epochs: trained.epochs as u64,
        validation_mae_m: trained.validation_mae,
        paper_mae_m: network.paper_mae_m,
    }
}

/// The trials that a failure before them made impossible: one row a target, as there would have been.
fn failed_trials(cell: &TrialCell, targets: usize, failure: &Failure) -> Vec<TrialRow> {
    let row = |target: usize| TrialRow {
        seed: 0,
        training: String::new(),
        policy: cell.policy.clone(),
        mode: String::new(),
        gp_points: 0,
        real_points: 0,
        target: target as u64,
        target_x_m: f64::NAN,
        target_y_m: f64::NAN,
        target_z_m: f64::NAN,
        tip_x_m: f64::NAN,
        tip_y_m: f64::NAN,
        tip_z_m: f64::NAN,
        error_m: f64::NAN,
        steps: 0,
        settled: false,
        switches: 0,
        status: failure.to_string(),
    };
    (0..targets).map(row).collect()
}

fn failed_track(cell: &TrialCell, failure: &Failure) -> TrackRow {
    TrackRow {
        seed: 0,
        training: String::new(),
        policy: cell.policy.clone(),
        step: 0,
        time_s: 0.0,
        path_point: 0,
        target_x_m: f64::NAN,
        target_y_m: f64::NAN,
        target_z_m: f64::NAN,
        tip_x_m: f64::NAN,
        tip_y_m: f64::NAN,
        tip_z_m: f64::NAN,
        error_m: f64::NAN,
        branch: String::new(),
        status: failure.to_string(),
    }
}
