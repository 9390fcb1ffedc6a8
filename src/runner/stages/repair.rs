//! The stages of repairs: the robot at work, its monitor, and for each change what is noticed,
//! told, mended and run again.

use super::{Added, Stages, points_of};
use crate::base::Point3;
use crate::discovery::Options;
use crate::effects::EffectSpec;
use crate::learn::gp::Gp;
use crate::learn::networks::Trained;
use crate::policies::{self, ModelNeed, NetworkDescription, PolicyEntry, TrainingData};
use crate::rows::cell::CellLabel;
use crate::rows::experiment::ReachTrial;
use crate::runner::graph::failure::Failure;
use crate::runner::graph::stage::Handle;
use crate::runner::jobs::data::exploration::{EXPLORE, ExploreParams, REPLAY, ReplayParams};
use crate::runner::jobs::learning::gaussian_process::GP;
use crate::runner::jobs::learning::networks::train;
use crate::runner::jobs::parts::identified::Identified;
use crate::runner::jobs::repair::diagnose::{DIAGNOSE, DiagnoseParams, IDENTIFY};
use crate::runner::jobs::repair::diagnosis::Diagnosis;
use crate::runner::jobs::repair::gp_repaired::{GP_MOVED, GP_REPAIRED, GpRepairedParams};
use crate::runner::jobs::repair::nearest::{NEAREST, NearestParams};
use crate::runner::jobs::repair::repaired::EXPLORE_REPAIRED;
use crate::runner::jobs::repair::retrain::RETRAIN;
use crate::runner::jobs::repair::work::{ALARM, MONITOR, TriedMonitor, WorkParams};
use crate::runner::jobs::trials::reach_track::{PartHandles, REACH, ReachParams};
use crate::specs::{PlantSpec, RepairRun, Training, TrialMode, repair_cells, repair_worker};
use crate::tasks::{ExploreOptions, LoopMode, Transitions};

/// What is run on a robot before a change, after it, and mended in one of several ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RepairVariant {
    /// The unchanged robot.
    Before,
    /// The changed robot, the controller as it was.
    Changed,
    /// The model got the named lines; networks were trained on with it.
    Repaired,
    /// The error model's points were moved by what the named lines do in the model; networks of
    /// simulated data are as they were.
    Moved,
    /// An error model of new points of the changed robot, and networks of generated data trained on
    /// with it.
    NewPoints,
    /// Networks of real data trained on new data of the changed robot.
    NewReal,
}

impl RepairVariant {
    /// Name in tables.
    pub(crate) fn name(self) -> &'static str {
        match self {
            RepairVariant::Before => "before",
            RepairVariant::Changed => "changed",
            RepairVariant::Repaired => "repaired",
            RepairVariant::Moved => "moved_points",
            RepairVariant::NewPoints => "new_points",
            RepairVariant::NewReal => "new_real",
        }
    }

    /// The variants of a policy: there is nothing to mend in one that was trained on nothing.
    fn of(entry: &PolicyEntry) -> Vec<RepairVariant> {
        let mut variants = vec![RepairVariant::Before, RepairVariant::Changed];
        let simulated = entry.networks().any(|network| {
            matches!(network.data, TrainingData::Simulated | TrainingData::Generated)
        });
        variants.extend(simulated.then_some(RepairVariant::Repaired));
        if entry.uses_error_model() {
            variants.extend([RepairVariant::Moved, RepairVariant::NewPoints]);
        }
        variants.extend(entry.uses_real_data().then_some(RepairVariant::NewReal));
        variants
    }
}

/// The stages of one change.
pub(crate) struct RepairStages {
    /// Name of the change.
    pub(crate) change: String,
    /// What changes.
    pub(crate) truth: Vec<EffectSpec>,
    /// The time of work until the alarm, seconds.
    pub(crate) alarm: Handle<Option<f64>>,
    /// What was found out.
    pub(crate) diagnosis: Handle<Diagnosis>,
    /// How near the changed robot can come to the targets, metres.
    pub(crate) nearest_m: Handle<f64>,
    /// Goal reaching.
    pub(crate) trials: Vec<(RepairVariant, CellLabel, Handle<Vec<ReachTrial>>)>,
}

/// The monitor and all changes of one repetition and training.
pub(crate) struct RepairCampaign {
    /// The monitor, tried on the unchanged robot.
    pub(crate) monitor: Handle<TriedMonitor>,
    /// What the model lacked of the robot as it was built.
    pub(crate) identified: Handle<Diagnosis>,
    /// How near the unchanged robot can come to the targets, metres.
    pub(crate) nearest_m: Handle<f64>,
    /// The changes, by name.
    pub(crate) changes: Vec<RepairStages>,
}

impl RepairCampaign {
    /// Numbers of the stages whose results are published.
    pub(crate) fn wanted(&self) -> Vec<usize> {
        let stages_of = |change: &RepairStages| {
            let trials = change.trials.iter().map(|(_, _, stage)| stage.number());
            [change.alarm.number(), change.diagnosis.number(), change.nearest_m.number()]
                .into_iter()
                .chain(trials)
                .collect::<Vec<_>>()
        };
        let shared_stages =
            [self.monitor.number(), self.identified.number(), self.nearest_m.number()];
        shared_stages.into_iter().chain(self.changes.iter().flat_map(stages_of)).collect()
    }
}

/// What the repair of one repetition and training is made of.
struct Repair<'a> {
    run: &'a RepairRun,
    training: &'a Training,
    worker: CellLabel,
    pool: Handle<Vec<Point3>>,
    gp: Handle<Gp>,
    monitor: Handle<TriedMonitor>,
    /// The recording of the robot as it was built, and what the model lacks of that.
    built: Handle<Transitions>,
    identified: Handle<Diagnosis>,
}

/// A change, and what is made of it.
struct Change<'a> {
    name: &'a str,
    effects: &'a [EffectSpec],
    /// The changed robot.
    plant: Identified,
    /// The recording after the alarm.
    recorded: Handle<Transitions>,
    diagnosis: Handle<Diagnosis>,
    /// The exploration on the repaired model.
    samples: Handle<Transitions>,
}

/// What a variant replaces in the parts of a policy.
struct NewParts {
    /// Data of simulated networks, where the model has changed.
    samples: Option<Handle<Transitions>>,
    /// Real data, where they are new.
    real: Option<Handle<Transitions>>,
    gp: Option<Handle<Gp>>,
}

impl Stages<'_> {
    /// The monitor and the changes of `runs.repair`; nothing without it.
    pub(crate) fn repair(
        &mut self,
        training: &Training,
    ) -> Result<Option<RepairCampaign>, Failure> {
        let Some(run) = &self.spec.runs.repair else { return Ok(None) };
        let (pool, worker) = (self.target_pool()?, repair_worker(self.spec, run));
        let gp = self.gp(training, run.gp_points)?;
        let (parts, params) = self.work(run, &worker, training, &[], "monitor")?;
        let monitor =
            self.graph.stage(&MONITOR, self.label("monitor"), params, (parts, pool, gp))?;
        let built =
            self.recording(self.parts.plant.clone(), run.recordings.trials_before, "built", run)?;
        let params = self.diagnose_params(run.identification_options())?;
        let identified =
            self.graph.stage(&IDENTIFY, self.label("identification"), params, built)?;
        let repair = Repair { run, training, worker, pool, gp, monitor, built, identified };
        let changes = run.changes.iter().map(|(name, effects)| self.change(&repair, name, effects));
        let changes = changes.collect::<Result<_, Failure>>()?;
        Ok(Some(RepairCampaign {
            monitor,
            identified,
            nearest_m: self.nearest(&[], "unchanged")?,
            changes,
        }))
    }

    /// The parts of the policy that works, and its work on the robot with these effects.
    fn work(
        &mut self,
        run: &RepairRun,
        worker: &CellLabel,
        training: &Training,
        effects: &[EffectSpec],
        task: &str,
    ) -> Result<(PartHandles, WorkParams), Failure> {
        let mode =
            TrialMode { feedback: LoopMode::Closed, effects: effects.to_vec(), change: None };
        let (entry, condition) = self.condition_in(&worker.policy, &mode, task)?;
        let parts = self.part_handles(entry, worker, training)?;
        Ok((parts, WorkParams { condition, model: self.parts.model.clone(), options: run.monitor }))
    }

    fn change(
        &mut self,
        repair: &Repair,
        name: &str,
        effects: &[EffectSpec],
    ) -> Result<RepairStages, Failure> {
        let (parts, params) =
            self.work(repair.run, &repair.worker, repair.training, effects, "alarm")?;
        let label = self.label(&format!("{} works, {name}", repair.worker.policy));
        let inputs = ((parts, repair.pool, repair.gp), repair.monitor);
        let alarm = self.graph.stage(&ALARM, label, params, inputs)?;
        let plant = Identified::new(self.spec.plant.with_effects(effects))?;
        let changed = self.recording(
            plant.clone(),
            repair.run.recordings.trials_after,
            "changed",
            repair.run,
        )?;
        let params = self.diagnose_params(repair.run.discovery.clone())?;
        let inputs = (repair.built, changed, repair.identified);
        let diagnosis = self.graph.stage(
            &DIAGNOSE,
            self.label(&format!("diagnosis, {name}")),
            params,
            inputs,
        )?;
        let label = self.label(&format!("exploration on the model repaired for {name}"));
        let samples =
            self.graph.stage(&EXPLORE_REPAIRED, label, self.explore_params(), diagnosis)?;
        let change = Change { name, effects, plant, recorded: changed, diagnosis, samples };
        let nearest_m = self.nearest(effects, name)?;
        let mut trials = Vec::new();
        for cell in repair_cells(self.spec) {
            let Some(entry) = policies::find_with(&cell.policy, &self.spec.policies.outside) else {
                continue;
            };
            for variant in RepairVariant::of(entry) {
                trials.push((
                    variant,
                    cell.clone(),
                    self.repair_trials(repair, &change, entry, &cell, variant)?,
                ));
            }
        }
        Ok(RepairStages {
            change: name.to_owned(),
            truth: effects.to_vec(),
            alarm,
            diagnosis,
            nearest_m,
            trials,
        })
    }

    /// How near a robot with these effects can come to the targets.
    fn nearest(&mut self, effects: &[EffectSpec], name: &str) -> Added<f64> {
        let (robot, travel_m) = (self.parts.plant.clone(), self.parts.policies.limits.travel_m);
        let params =
            NearestParams { robot, effects: effects.to_vec(), travel_m, step_s: self.step_s() };
        let targets = self.targets()?;
        self.graph.stage(
            &NEAREST,
            self.label(&format!("nearest to the targets, {name}")),
            params,
            targets,
        )
    }

    /// Random walks that are drawn on the model and played on a robot: all tendons then go where
    /// they are told from the start of a step, as on a bench, and none follows what the tip does.
    fn recording(
        &mut self,
        robot: Identified,
        trials: usize,
        name: &str,
        run: &RepairRun,
    ) -> Added<Transitions> {
        let points = trials * (run.recordings.rows - 1);
        let options = ExploreOptions { points, trajectories: trials, ..self.spec.explore };
        let (step_s, seed) = (self.step_s(), self.seed.child("repair").child(name).0);
        let walk = ExploreParams { model: self.parts.model.clone(), options, step_s, seed };
        let walked =
            self.graph.stage(&EXPLORE, self.label(&format!("random walk, {name}")), walk, ())?;
        let replay = ReplayParams { plant: robot, step_s, seed };
        self.graph.stage(&REPLAY, self.label(&format!("recording, {name}")), replay, walked)
    }

    fn diagnose_params(&self, options: Options) -> Result<DiagnoseParams, Failure> {
        let PlantSpec::Simulated(simulated) = &self.spec.model else {
            return Err(Failure {
                stage: "diagnose".into(),
                status: "the model is no simulated rod".into(),
            });
        };
        let model = simulated.model.clone();
        Ok(DiagnoseParams { model, options, step_s: self.step_s() })
    }

    /// Goal reaching in one cell of one variant.
    fn repair_trials(
        &mut self,
        repair: &Repair,
        change: &Change,
        entry: &'static PolicyEntry,
        cell: &CellLabel,
        variant: RepairVariant,
    ) -> Added<Vec<ReachTrial>> {
        let parts = match variant {
            RepairVariant::Before | RepairVariant::Changed => {
                self.part_handles(entry, cell, repair.training)?
            }
            _ => self.new_parts(repair, change, entry, cell, variant)?,
        };
        let unknown =
            || Failure { stage: "reach".into(), status: format!("unknown {}", cell.mode) };
        let mut mode = self.spec.modes.get(&cell.mode).cloned().ok_or_else(unknown)?;
        if variant != RepairVariant::Before {
            mode.effects.extend(change.effects.iter().cloned());
        }
        let (_, condition) = self.condition_in(&cell.policy, &mode, "reach")?;
        let params = ReachParams { condition, options: self.spec.reach };
        let inputs = (parts, self.targets()?);
        let label = self.label(&format!(
            "{} {} {} {}",
            cell.policy,
            cell.mode,
            change.name,
            variant.name()
        ));
        self.graph.stage(&REACH, label, params, inputs)
    }

    fn new_parts(
        &mut self,
        repair: &Repair,
        change: &Change,
        entry: &PolicyEntry,
        cell: &CellLabel,
        variant: RepairVariant,
    ) -> Result<PartHandles, Failure> {
        let repaired = variant == RepairVariant::Repaired;
        let gp = entry
            .uses_error_model()
            .then(|| self.new_gp(change, cell.gp_points as usize, variant))
            .transpose()?;
        let real =
            (variant == RepairVariant::NewReal).then(|| self.new_real(change)).transpose()?;
        let new = NewParts { samples: repaired.then_some(change.samples), real, gp };
        let (mut networks, mut error) = (Vec::new(), None);
        for need in entry.needs {
            match need {
                ModelNeed::Network(network) => {
                    networks.push(self.new_network(repair, &new, network, cell)?)
                }
                ModelNeed::ErrorModel => error = new.gp,
            }
        }
        Ok((networks, error))
    }

    /// A network of new data, trained on from where it is; the one that is there where its data
    /// have not changed.
    fn new_network(
        &mut self,
        repair: &Repair,
        new: &NewParts,
        network: &'static NetworkDescription,
        cell: &CellLabel,
    ) -> Added<Trained> {
        let points = points_of(network, cell);
        let params = self.network_params(network, repair.training, points);
        let present = self.network(network, repair.training, points)?;
        let label = self.label(&format!("{}, trained on", network.label));
        match (network.data, new) {
            (TrainingData::Simulated, NewParts { samples: Some(samples), .. }) => {
                let inputs = (present, *samples, None);
                self.graph.stage(&RETRAIN, label, (network.name.to_owned(), params), inputs)
            }
            (TrainingData::Generated, NewParts { samples, gp: Some(gp), .. }) => {
                let inputs = (present, samples.map_or_else(|| self.explore(), Ok)?, Some(*gp));
                self.graph.stage(&RETRAIN, label, (network.name.to_owned(), params), inputs)
            }
            (TrainingData::Real, NewParts { real: Some(real), .. }) => {
                let label = self.label(&format!("{}, new data", network.label));
                self.graph.stage(&train(network), label, params, *real)
            }
            _ => Ok(present),
        }
    }

    /// The error model of a variant: of so many new points of the changed robot, or of so many
    /// points from before the change and the recording after it.
    fn new_gp(&mut self, change: &Change, points: usize, variant: RepairVariant) -> Added<Gp> {
        let label = self.label(&format!(
            "Gaussian process, {points} points, {} {}",
            change.name,
            variant.name()
        ));
        let gp = self.gp_params(points);
        if variant == RepairVariant::NewPoints {
            let pool =
                self.pool_of(change.plant.clone(), &format!("new points, {}", change.name))?;
            return self.graph.stage(&GP, label, gp, (pool, None));
        }
        let stage = if variant == RepairVariant::Moved { &GP_MOVED } else { &GP_REPAIRED };
        let params =
            GpRepairedParams { model: self.parts.model.clone(), step_s: self.step_s(), gp };
        let inputs = (self.gp_pool()?, change.recorded, change.diagnosis);
        self.graph.stage(stage, label, params, inputs)
    }

    /// What the changed robot does under the commands of the exploration.
    fn new_real(&mut self, change: &Change) -> Added<Transitions> {
        let explored = self.explore()?;
        let (step_s, seed) = (self.step_s(), self.seed.child("replay").0);
        let params = ReplayParams { plant: change.plant.clone(), step_s, seed };
        self.graph.stage(&REPLAY, self.label(&format!("replay, {}", change.name)), params, explored)
    }
}
