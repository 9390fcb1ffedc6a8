//! Stage results to published rows: every label is filled in here, failures become rows, everything
//! is in a fixed order.

use super::metrics::Tables;
use super::repair_tables;
use crate::base::Outcome;
use crate::benchmark::{DrawnEffect, ScoredCase};
use crate::learn::networks::Trained;
use crate::policies::{NetworkDescription, TrainingData};
use crate::report::{Published, track_summary};
use crate::rows::cell::{CellLabel, CellRow};
use crate::rows::experiment::{
    GapRow, GpCoverageRow, GpLeaveOneOutRow, GpRow, NetworkRow, ReachTrial, TrackRow, TrackSample,
    WaypointRow,
};
use crate::rows::population::RobotRow;
use crate::rows::responses::{PaceLap, ResponseTrial};
use crate::runner::campaign::{CampaignEntry, PointStages, TrainedCells};
use crate::runner::execute::outcomes::Outcomes;
use crate::runner::graph::stage::StageResult;
use crate::runner::graph::{Failure, Handle};
use crate::specs::Experiment;

impl CampaignEntry {
    /// The tables of each point of its sweep, of its only one without a sweep.
    pub fn tables(&self, outcomes: &Outcomes) -> impl Iterator<Item = Tables> {
        self.points.iter().map(|point| point.tables(outcomes))
    }
}

impl PointStages {
    /// The tables of this point: rows sorted, failures as rows with a status.
    pub(crate) fn tables(&self, outcomes: &Outcomes) -> Tables {
        let mut tables = Tables::default();
        let published = &mut tables.published;
        for repetition in &self.repetitions {
            let seed = repetition.seed;
            published.robots.extend(
                repetition.robot_effects.iter().flat_map(|effect| robot_rows(seed, effect)),
            );
            let gaps = repetition.gap.into_iter().flat_map(|stage| all(outcomes, stage));
            published.gaps.extend(gaps.map(|gap| GapRow { seed, gap }));
            let waypoints = repetition.waypoints.into_iter().flat_map(|stage| all(outcomes, stage));
            published.waypoints.extend(waypoints.enumerate().map(|(waypoint, [x_m, y_m, z_m])| {
                WaypointRow { seed, waypoint: waypoint as u64, x_m, y_m, z_m }
            }));
            for (training, stage) in &repetition.gps {
                let score = outcomes.get(*stage).ok().cloned();
                published.gps.extend(score.map(|score| GpRow {
                    seed,
                    training: training.clone(),
                    score,
                }));
            }
            for (training, stage) in &repetition.gp_coverages {
                let row = |coverage| GpCoverageRow { seed, training: training.clone(), coverage };
                published.gp_coverages.extend(all(outcomes, *stage).map(row));
            }
            for (training, stage) in &repetition.gp_left_out {
                let row =
                    |left_out| GpLeaveOneOutRow { seed, training: training.clone(), left_out };
                published.gp_left_out.extend(all(outcomes, *stage).map(row));
            }
            for ScoredCase { row, intervals } in
                repetition.blind.iter().map(|case| case.scored(outcomes))
            {
                published.cases.push(row);
                published.intervals.extend(intervals);
            }
            for cells in &repetition.trained {
                add_trained(published, &self.experiment, seed, cells, outcomes);
            }
        }
        tables.runs = track_summary(&tables.published.tracks);
        tables
    }
}

/// The values of a stage; none where it failed.
fn all<T: Clone>(outcomes: &Outcomes, stage: Handle<Vec<T>>) -> impl Iterator<Item = T>
where
    Vec<T>: StageResult,
{
    outcomes.get(stage).into_iter().flatten().cloned()
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

/// Rows of one seed and training. Seeds ascend, trainings and cells are in the order of their
/// expansion.
fn add_trained(
    published: &mut Published,
    experiment: &Experiment,
    seed: u64,
    cells: &TrainedCells,
    outcomes: &Outcomes,
) {
    let repetition = TrainedRepetition { seed, training: &cells.training, outcomes };
    let training = &cells.training;
    for (network, points, stage) in &cells.networks {
        if let Ok(trained) = outcomes.get(*stage) {
            published.networks.push(repetition.network_row(network, *points, trained, experiment));
        }
    }
    let targets = 0..experiment.targets.drawn as u64;
    let lap = experiment
        .runs
        .pace
        .iter()
        .flat_map(|run| run.speeds.iter().map(|speed| (*speed, run.lap_s / speed)));
    published.trials.extend(repetition.rows(&cells.reach, |status| {
        targets.clone().map(|target| ReachTrial::unmeasured(target, status.clone())).collect()
    }));
    published.responses.extend(repetition.rows(&cells.response, |status| {
        targets.clone().map(|target| ResponseTrial::unmeasured(target, status.clone())).collect()
    }));
    published.paces.extend(repetition.rows(&cells.pace, |status| {
        lap.clone()
            .map(|(speed, lap_s)| PaceLap::unmeasured(speed, lap_s, status.clone()))
            .collect()
    }));
    for (cell, stage) in &cells.track {
        let samples = repetition.values(*stage, |status| vec![TrackSample::unmeasured(status)]);
        let is_first = seed == 0;
        let pulls_m = |sample: &TrackSample| {
            if is_first { sample.pulls_m.clone() } else { String::new() }
        };
        let row = |sample: TrackSample| TrackRow {
            seed,
            training: training.clone(),
            policy: cell.policy.clone(),
            sample: TrackSample { pulls_m: pulls_m(&sample), ..sample },
        };
        published.tracks.extend(samples.into_iter().map(row));
    }
    if let Some(repair) = &cells.repair {
        repair_tables::add(published, &repetition, repair, experiment.targets.drawn);
    }
}

/// One seed and training, and what became of its stages.
pub(crate) struct TrainedRepetition<'a> {
    pub(crate) seed: u64,
    pub(crate) training: &'a str,
    pub(crate) outcomes: &'a Outcomes,
}

impl TrainedRepetition<'_> {
    /// The values of a stage, or those that stand for its failure.
    pub(crate) fn values<T: Clone>(
        &self,
        stage: Handle<Vec<T>>,
        unmeasured: impl FnOnce(Outcome) -> Vec<T>,
    ) -> Vec<T>
    where
        Vec<T>: StageResult,
    {
        let failed = |failure: Failure| unmeasured(Outcome::Failed(failure.to_string()));
        self.outcomes.get(stage).map_or_else(failed, Clone::clone)
    }

    /// The rows of cells: what was measured, with its label.
    fn rows<T: Clone>(
        &self,
        cells: &[(CellLabel, Handle<Vec<T>>)],
        unmeasured: impl Fn(Outcome) -> Vec<T>,
    ) -> Vec<CellRow<T>>
    where
        Vec<T>: StageResult,
    {
        let row = |cell: &CellLabel, value: T| CellRow {
            seed: self.seed,
            training: self.training.to_owned(),
            cell: cell.clone(),
            value,
        };
        let of_cell = |(cell, stage): &(CellLabel, Handle<Vec<T>>)| {
            let values = self.values(*stage, &unmeasured).into_iter();
            values.map(|value| row(cell, value)).collect::<Vec<_>>()
        };
        cells.iter().flat_map(of_cell).collect()
    }

    fn network_row(
        &self,
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
            seed: self.seed,
            training: self.training.to_owned(),
            network: network.name.to_owned(),
            points: points as u64,
            epochs: trained.epochs as u64,
            validation_mae_m: trained.validation_mae,
            paper_mae_m: network.paper_mae_m,
        }
    }
}
