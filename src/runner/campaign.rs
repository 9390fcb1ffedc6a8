//! Experiments as stages of one graph, and the stages' results as the tables of each experiment.

use super::graph::{Failure, Graph, Handle};
use super::stages::{BlindStages, RepairCampaign, RepairVariant, SharedParts, Stages, points_of};
use crate::base::Point3;
use crate::benchmark::DrawnEffect;
use crate::effects::EffectSpec;
use crate::learn::networks::Trained;
use crate::policies::{self, FORWARD, NetworkDescription, PolicyEntry, networks};
use crate::rows::cell::CellLabel;
use crate::rows::experiment::{GapSample, GpCoverage, GpLeftOut, GpScore, ReachTrial, TrackSample};
use crate::rows::responses::{PaceLap, ResponseTrial};
use crate::specs::{
    Experiment, ExperimentSet, SweepPoint, SweptField, Training, gp_sizes, pace_cells, reach_cells,
    response_cells, track_cells, trial_cells,
};
use crate::tasks::SimulatedBy;
use std::collections::BTreeSet;
use std::sync::Arc;

/// In the place of a kind of training: none takes part.
pub(super) const ANY_TRAINING: &str = "any";

/// Some experiments, expanded into the stages that they need. What they share is there once.
pub struct Campaign {
    /// All stages.
    pub graph: Graph,
    /// The experiments with their stages, in the order given.
    pub entries: Vec<CampaignEntry>,
}

/// An experiment and its stages.
pub struct CampaignEntry {
    /// What is run; of a sweep, its first point.
    pub experiment: Experiment,
    /// What is swept; nothing for a single experiment.
    pub sweep: Vec<SweptField>,
    /// The spec with everything filled in.
    pub(super) spec_yaml: String,
    /// The points of the sweep, or the one experiment.
    pub(super) points: Vec<PointStages>,
}

/// The stages of one point of a sweep, or of the one experiment.
pub(crate) struct PointStages {
    /// Which of its values each swept field has.
    pub(super) values: Vec<usize>,
    pub(super) experiment: Arc<Experiment>,
    pub(super) repetitions: Vec<Repetition>,
}

/// One run, as it is planned.
pub struct PlannedRun {
    /// Task, seed, training, policy, mode and sizes.
    pub label: String,
    /// Number of its stage.
    pub stage: usize,
}

/// The stages of one seed.
#[derive(Default)]
pub(super) struct Repetition {
    pub(super) seed: u64,
    /// What its robot has beside the experiment's, where repetitions differ in their robots.
    pub(super) robot_effects: Vec<DrawnEffect>,
    pub(super) gap: Option<Handle<Vec<GapSample>>>,
    pub(super) waypoints: Option<Handle<Vec<Point3>>>,
    /// With the kind of training that each depends on.
    pub(super) gps: Vec<(String, Handle<GpScore>)>,
    /// What the intervals of the same processes cover, where that is asked for.
    pub(super) gp_coverages: Vec<(String, Handle<Vec<GpCoverage>>)>,
    pub(super) gp_left_out: Vec<(String, Handle<Vec<GpLeftOut>>)>,
    pub(super) trained: Vec<TrainedCells>,
    /// Blind cases of discovery.
    pub(super) blind: Vec<BlindStages>,
}

/// The stages of one seed and kind of training.
#[derive(Default)]
pub(super) struct TrainedCells {
    pub(super) training: String,
    /// With the points of the data that each depends on.
    pub(super) networks: Vec<(&'static NetworkDescription, usize, Handle<Trained>)>,
    pub(super) reach: Vec<(CellLabel, Handle<Vec<ReachTrial>>)>,
    pub(super) track: Vec<(CellLabel, Handle<Vec<TrackSample>>)>,
    pub(super) response: Vec<(CellLabel, Handle<Vec<ResponseTrial>>)>,
    pub(super) pace: Vec<(CellLabel, Handle<Vec<PaceLap>>)>,
    pub(super) repair: Option<RepairCampaign>,
}

impl Campaign {
    /// Expands experiments, or what their specs sweep.
    ///
    /// # Errors
    /// [`Failure`] for settings that cannot be written into a key.
    pub fn expand<S: Into<ExperimentSet>>(
        studies: impl IntoIterator<Item = S>,
    ) -> Result<Campaign, Failure> {
        let mut graph = Graph::default();
        let entries = studies
            .into_iter()
            .map(|study| expand_entry(&mut graph, study.into()))
            .collect::<Result<_, Failure>>()?;
        Ok(Campaign { graph, entries })
    }

    /// The stages whose results are published.
    pub fn wanted(&self) -> Vec<usize> {
        let numbers: BTreeSet<usize> =
            self.entries.iter().flat_map(CampaignEntry::wanted).collect();
        numbers.into_iter().collect()
    }
}

impl CampaignEntry {
    /// The stages whose results this experiment publishes.
    pub fn wanted(&self) -> BTreeSet<usize> {
        let mut numbers = BTreeSet::new();
        for repetition in self.points.iter().flat_map(|point| &point.repetitions) {
            numbers.extend(repetition.gap.map(Handle::number));
            numbers.extend(repetition.waypoints.map(Handle::number));
            numbers.extend(repetition.gps.iter().map(|(_, stage)| stage.number()));
            numbers.extend(repetition.gp_coverages.iter().map(|(_, stage)| stage.number()));
            numbers.extend(repetition.gp_left_out.iter().map(|(_, stage)| stage.number()));
            numbers.extend(repetition.blind.iter().flat_map(BlindStages::wanted));
            for trained in &repetition.trained {
                numbers.extend(trained.networks.iter().map(|(_, _, stage)| stage.number()));
                numbers.extend(trained.reach.iter().map(|(_, stage)| stage.number()));
                numbers.extend(trained.track.iter().map(|(_, stage)| stage.number()));
                numbers.extend(trained.response.iter().map(|(_, stage)| stage.number()));
                numbers.extend(trained.pace.iter().map(|(_, stage)| stage.number()));
                numbers.extend(trained.repair.iter().flat_map(RepairCampaign::wanted));
            }
        }
        numbers
    }

    /// The runs: products of swept values, seeds, trainings, policies, modes and sizes, in the
    /// order of their expansion.
    pub fn cells(&self) -> Vec<PlannedRun> {
        let mut runs = Vec::new();
        for point in &self.points {
            let swept = self.label(point);
            let swept = if swept.is_empty() { swept } else { format!(" {swept}") };
            point.repetitions.iter().for_each(|repetition| repetition.cells(&swept, &mut runs));
        }
        runs
    }

    /// The values of a point's swept fields, in words.
    pub(super) fn label(&self, point: &PointStages) -> String {
        SweepPoint { values: point.values.clone(), experiment: point.experiment.clone() }
            .label(&self.sweep)
    }
}

impl Repetition {
    fn cells(&self, swept: &str, runs: &mut Vec<PlannedRun>) {
        let blind = |case: &BlindStages| PlannedRun {
            label: case.label(self.seed) + swept,
            stage: case.last(),
        };
        runs.extend(self.blind.iter().map(blind));
        for trained in &self.trained {
            let head = format!("seed {} {}", self.seed, trained.training);
            let run = |task: &str, cell: &CellLabel, stage: usize| {
                let (policy, mode, gp, real) =
                    (&cell.policy, &cell.mode, cell.gp_points, cell.real_points);
                let gp = if gp > 0 { format!(" gp_points {gp}") } else { String::new() };
                let real = if real > 0 { format!(" real_points {real}") } else { String::new() };
                PlannedRun {
                    label: format!("{task} {head} {policy} {mode}{gp}{real}{swept}"),
                    stage,
                }
            };
            runs.extend(
                trained.reach.iter().map(|(cell, stage)| run("reach", cell, stage.number())),
            );
            runs.extend(
                trained.track.iter().map(|(cell, stage)| run("track", cell, stage.number())),
            );
            runs.extend(
                trained.response.iter().map(|(cell, stage)| run("response", cell, stage.number())),
            );
            runs.extend(trained.pace.iter().map(|(cell, stage)| run("pace", cell, stage.number())));
            for change in trained.repair.iter().flat_map(|repair| &repair.changes) {
                let task = |variant: &RepairVariant| {
                    format!("repair {} {}", change.change, variant.name())
                };
                let trials = change.trials.iter();
                runs.extend(
                    trials.map(|(variant, cell, stage)| run(&task(variant), cell, stage.number())),
                );
            }
        }
    }
}

/// The stages of one study.
fn expand_entry(graph: &mut Graph, study: ExperimentSet) -> Result<CampaignEntry, Failure> {
    let failed = |status: String| Failure { stage: "spec".into(), status };
    let spec_yaml = study.to_yaml().map_err(failed)?;
    let ExperimentSet { experiment, sweep, mut points, .. } = study;
    if points.is_empty() {
        points.push(SweepPoint { values: Vec::new(), experiment: Arc::new(experiment.clone()) });
    }
    let mut stages = Vec::with_capacity(points.len());
    let mut previous: Option<SharedParts> = None;
    for SweepPoint { values, experiment } in points {
        let repetitions = match experiment.population {
            None => expand_repetitions(graph, &experiment, &mut previous)?,
            Some(_) => expand_population(graph, &experiment, &mut previous)?,
        };
        stages.push(PointStages { values, experiment, repetitions });
    }
    Ok(CampaignEntry { experiment, sweep, spec_yaml, points: stages })
}

/// Repetitions on one robot. Parts that equal those of `previous` are shared with it.
fn expand_repetitions(
    graph: &mut Graph,
    experiment: &Experiment,
    previous: &mut Option<SharedParts>,
) -> Result<Vec<Repetition>, Failure> {
    let parts = SharedParts::new(experiment, previous.as_ref())?;
    let seeds = experiment.repetitions();
    let repetitions =
        seeds.map(|seed| expand_repetition(graph, experiment, &parts, seed)).collect();
    *previous = Some(parts);
    repetitions
}

/// Repetitions with a robot each.
fn expand_population(
    graph: &mut Graph,
    experiment: &Experiment,
    previous: &mut Option<SharedParts>,
) -> Result<Vec<Repetition>, Failure> {
    let mut repetitions = Vec::new();
    for seed in experiment.repetitions() {
        let robot_effects = experiment.drawn_effects(seed);
        let effects: Vec<EffectSpec> =
            robot_effects.iter().map(|effect| effect.spec.clone()).collect();
        let on_robot =
            Experiment { plant: experiment.plant.with_effects(&effects), ..experiment.clone() };
        let parts = SharedParts::new(&on_robot, previous.as_ref())?;
        let repetition = expand_repetition(graph, &on_robot, &parts, seed)?;
        repetitions.push(Repetition { robot_effects, ..repetition });
        *previous = Some(parts);
    }
    Ok(repetitions)
}

fn expand_repetition(
    graph: &mut Graph,
    experiment: &Experiment,
    parts: &SharedParts,
    seed: u64,
) -> Result<Repetition, Failure> {
    let mut stages = Stages::new(graph, experiment, parts, seed);
    let mut repetition = Repetition { seed, ..Repetition::default() };
    repetition.gap = experiment.runs.gap.map(|gap| stages.gap(gap.rows)).transpose()?;
    let path = experiment.runs.track.is_some() || experiment.runs.pace.is_some();
    repetition.waypoints = path.then(|| stages.waypoints()).transpose()?;
    let processes = gaussian_processes(experiment);
    for (name, training, points) in &processes {
        repetition.gps.push((name.clone(), stages.gp_score(training, *points)?));
        if !experiment.runs.gp_coverage.is_empty() {
            repetition.gp_coverages.push((name.clone(), stages.gp_coverage(training, *points)?));
        }
        if !experiment.runs.gp_leave_one_out.is_empty() {
            repetition
                .gp_left_out
                .push((name.clone(), stages.gp_leave_one_out(training, *points)?));
        }
    }
    repetition.blind = stages.blind()?;
    let (reach, track) = (reach_cells(experiment), track_cells(experiment));
    for (name, training) in &experiment.training {
        let mut cells = TrainedCells { training: name.clone(), ..TrainedCells::default() };
        for (network, points) in networks_of(experiment, trial_cells(experiment)) {
            cells.networks.push((network, points, stages.network(network, training, points)?));
        }
        for cell in &reach {
            cells.reach.push((cell.clone(), stages.reach(cell, training)?));
        }
        for cell in &track {
            cells.track.push((cell.clone(), stages.track(cell, training)?));
        }
        for (cell, run) in
            response_cells(experiment).into_iter().zip(experiment.runs.response.iter().cycle())
        {
            let stage = stages.response(&cell, training, run.duration_s)?;
            cells.response.push((cell, stage));
        }
        for (cell, run) in
            pace_cells(experiment).into_iter().zip(experiment.runs.pace.iter().cycle())
        {
            let stage = stages.pace(&cell, training, run)?;
            cells.pace.push((cell, stage));
        }
        cells.repair = stages.repair(training)?;
        repetition.trained.push(cells);
    }
    Ok(repetition)
}

/// The experiment's Gaussian processes: kind of training, where its networks stop, and size. There
/// is one a size, or where p_sim comes from the forward network, one a size and training.
fn gaussian_processes(experiment: &Experiment) -> Vec<(String, Training, usize)> {
    let rod = experiment.gp_points.p_sim == SimulatedBy::Rod;
    let trainings = if rod {
        vec![(ANY_TRAINING.to_owned(), Training::default())]
    } else {
        experiment.training.iter().map(|(name, training)| (name.clone(), *training)).collect()
    };
    let sizes = gp_sizes(experiment);
    let of_size = |(name, training): (String, Training)| {
        sizes.iter().map(move |&points| (name.clone(), training, points))
    };
    trainings.into_iter().flat_map(of_size).collect()
}

/// The networks that the cells are built from with the points of their data, and the forward model
/// where it is asked for or stands for the rod; in the order of [`networks`].
fn networks_of(
    experiment: &Experiment,
    cells: impl Iterator<Item = CellLabel>,
) -> Vec<(&'static NetworkDescription, usize)> {
    let all_networks = networks();
    let rank = |network: &NetworkDescription| {
        all_networks.iter().position(|other| other.name == network.name)
    };
    let simulates =
        experiment.gp_points.p_sim == SimulatedBy::Network && !gp_sizes(experiment).is_empty();
    let mut used = BTreeSet::new();
    used.extend((experiment.runs.forward || simulates).then_some((rank(&FORWARD), 0)));
    for cell in cells {
        for network in policies::find(&cell.policy).into_iter().flat_map(PolicyEntry::networks) {
            used.insert((rank(network), points_of(network, &cell)));
        }
    }
    used.into_iter().filter_map(|(rank, points)| Some((all_networks[rank?], points))).collect()
}
