//! A driven model: its rod, the effects on drives and measurements, and derivatives with respect to
//! model parameters, commands and loads. Measurement noise is added by the simulated plant.

use nalgebra::Vector3;

use super::drive_path::{DrivePath, DriveState, apply_effects, drives};
use super::perturbation::{Perturbation, perturb};
use crate::base::{Observation, PlantError, TendonCommand};
use crate::effects::VariationError;
use crate::effects::model::parameter::Variable;
use crate::effects::model::tracking::{MeasuredPose, TrackedPlaces, seen_point};
use crate::effects::{Effect, EffectSpec, Model};
use crate::math::rotation;
use crate::rod::{
    Drive, NotPerturbable, PerturbedRods, PoseRates, Rod, RodParams, SolveStatus, TensionSplit,
    TipRate, TipWrench,
};

/// A rod with the effects of a model.
#[derive(Clone, Debug)]
pub struct DrivenModel {
    rods: PerturbedRods,
    /// Effects of the model, then of each perturbed model.
    effects: Vec<Vec<Box<dyn Effect>>>,
    /// Drives of each rod.
    drive_states: Vec<DriveState>,
    perturbations: Vec<Perturbation>,
    /// What is tracked on the model, then on each perturbed model.
    places: Vec<TrackedPlaces>,
    /// Displacements of the model's drives in the next command, in the order of their names.
    drive_displacements: Vec<f64>,
    /// Index of the next command; `None` before the command that brings the rod home after a
    /// restart.
    next: Option<usize>,
}

impl DrivenModel {
    /// A checked model with `extra` effects on top.
    pub fn new(model: &Model, extra: &[EffectSpec]) -> DrivenModel {
        let rods = PerturbedRods::alone(model.rod(extra));
        let drive_state =
            DriveState::new(model.robot.drive_time_s, rods.leader().params().tendons.len());
        DrivenModel {
            rods,
            effects: vec![model.effects(extra)],
            drive_states: vec![drive_state],
            perturbations: Vec::new(),
            places: vec![model.tracking.places()],
            drive_displacements: Vec::new(),
            next: None,
        }
    }

    /// The same, with derivatives of every observation with respect to `variables`.
    ///
    /// # Errors
    /// [`VariationError`] for the first variable without one.
    pub fn varied(
        model: &Model,
        extra: &[EffectSpec],
        variables: &[Variable],
    ) -> Result<DrivenModel, VariationError> {
        let mut driven = DrivenModel::new(model, extra);
        let mut params = Vec::new();
        for (index, variable) in variables.iter().enumerate() {
            let varied = perturb(model, extra, variable, index)?;
            driven.effects.push(varied.effects);
            driven
                .drive_states
                .push(DriveState::new(varied.drive_time_s, driven.rod().params().tendons.len()));
            driven.perturbations.push(varied.perturbation);
            driven.places.push(varied.places);
            params.push(varied.params);
        }
        // The model itself is number 0, the first variable number 1.
        driven.rods = PerturbedRods::new(model.rod(extra), params)
            .map_err(|NotPerturbable(number)| VariationError::NotPerturbable(number - 1))?;
        Ok(driven)
    }

    /// The same with derivatives for those of `variables` that have one; also returns the indices
    /// (from 0) of the others.
    ///
    /// # Errors
    /// [`VariationError`] for a variable that does not exist.
    pub fn varied_where_possible(
        model: &Model,
        extra: &[EffectSpec],
        variables: &[Variable],
    ) -> Result<(DrivenModel, Vec<usize>), VariationError> {
        let mut kept: Vec<usize> = (0..variables.len()).collect();
        let mut left_out = Vec::new();
        loop {
            let variables_kept: Vec<Variable> =
                kept.iter().map(|&index| variables[index].clone()).collect();
            match DrivenModel::varied(model, extra, &variables_kept) {
                Err(VariationError::NotPerturbable(index)) => left_out.push(kept.remove(index)),
                driven => {
                    left_out.sort_unstable();
                    return driven.map(|driven| (driven, left_out));
                }
            }
        }
    }

    /// The rod of the model.
    pub fn rod(&self) -> &Rod {
        self.rods.leader()
    }

    /// The tensions now, where rigid tendons leave their split undetermined with the least norm.
    pub fn tension_split(&self) -> TensionSplit {
        self.rod().tension_split(&self.drive_states[0].actual_m)
    }

    /// Restarts: straight, no history, slack tendons. The first command brings the rod home; the
    /// next one has index 0.
    pub fn restart(&mut self) {
        self.rods.restart();
        self.effects.iter_mut().flatten().for_each(|effect| effect.reset());
        for drive_state in &mut self.drive_states {
            drive_state.commanded_m.fill(0.0);
            drive_state.actual_m.fill(0.0);
        }
        self.drive_displacements.clear();
        self.next = None;
    }

    /// Says how far the model's drives are displaced (radians or metres, in the order of their
    /// names) in the commands from now on: what a change of their gains is multiplied by. A restart
    /// forgets it.
    pub fn set_drive_displacements(&mut self, displacements: Vec<f64>) {
        self.drive_displacements = displacements;
    }

    /// Restarts and settles at home; the next command has index 0.
    ///
    /// # Errors
    /// As [`DrivenModel::settle`].
    pub fn home(&mut self) -> Result<(), PlantError> {
        self.restart();
        let tendons = self.rod().params().tendons.len();
        self.settle(&vec![TendonCommand::Pull(0.0); tendons])
    }

    /// Restarts away from home: the next command is the first one, with index 0, and finds the
    /// robot straight and unloaded.
    pub fn restart_away(&mut self) {
        self.restart();
        self.rods.rest_for_good();
        self.next = Some(0);
    }

    /// Counts the next command as the first one again: after settling under the first command of a
    /// trial that does not start at home.
    pub fn restart_count(&mut self) {
        self.next = Some(0);
    }

    /// Restarts and settles without tensions; the next command has index 0.
    ///
    /// # Errors
    /// As [`DrivenModel::settle`].
    pub fn slack(&mut self) -> Result<(), PlantError> {
        self.restart();
        let tendons = self.rod().params().tendons.len();
        self.settle_under(&vec![0.0; tendons])
    }

    /// Replaces the tip load in addition to the model's; `load` may depend on the rod (for example
    /// on its gravity).
    pub fn set_extra_tip_load(&mut self, load: &dyn Fn(&RodParams) -> TipWrench) {
        self.rods.set_tip_load(&|params| {
            let (model_load, extra) = (params.tip_load, load(params));
            TipWrench {
                force_n: model_load.force_n + extra.force_n,
                moment_nm: model_load.moment_nm + extra.moment_nm,
            }
        });
    }

    /// Settles under `commands`, one per tendon.
    ///
    /// # Errors
    /// [`PlantError`] when the commands do not fit this robot or no equilibrium is found.
    pub fn settle(&mut self, commands: &[TendonCommand]) -> Result<(), PlantError> {
        let targets = self.requested_m(commands)?;
        for ((drive_state, effects), target) in
            self.drive_states.iter_mut().zip(&mut self.effects).zip(targets)
        {
            drive_state.commanded_m.clone_from(&target);
            drive_state.actual_m = apply_effects(effects, target, f64::INFINITY);
        }
        self.count_command();
        let DrivenModel { rods, drive_states, .. } = self;
        solved(rods.settle(&|number| {
            drives(commands, &drive_states[number].actual_m, &drive_states[number].actual_m, 1.0)
        }))?;
        self.follow(commands);
        Ok(())
    }

    /// Moves the drives to `commands` and holds them, `duration_s` in all.
    ///
    /// # Errors
    /// As [`DrivenModel::settle`].
    pub fn advance(
        &mut self,
        commands: &[TendonCommand],
        duration_s: f64,
    ) -> Result<(), PlantError> {
        let targets = self.requested_m(commands)?;
        self.count_command();
        let each = self.drive_states.iter_mut().zip(&mut self.effects).zip(targets);
        let paths: Vec<DrivePath> = each
            .map(|((drive_state, effects), target)| {
                drive_state.move_to(effects, target, duration_s)
            })
            .collect();
        let parts = |number: usize| {
            // Followers use the leader's parts unless they have as many of their own.
            let source =
                if paths[number].ends_s.len() == paths[0].ends_s.len() { number } else { 0 };
            &paths[source].ends_s
        };
        let part_s = |number: usize, part: usize| {
            let start_s = if part == 0 { 0.0 } else { parts(number)[part - 1] };
            (start_s, parts(number)[part] - start_s)
        };
        // A command that ends with its ramp has a hold of no duration.
        for part in (0..paths[0].ends_s.len()).filter(|&part| part_s(0, part).1 > 1e-9 * duration_s)
        {
            let at =
                |number: usize, t: f64| paths[number].drives(commands, part_s(number, part).0 + t);
            solved(self.rods.advance_with(&at, &|number| part_s(number, part).1))?;
        }
        self.follow(commands);
        Ok(())
    }

    /// Settles under tensions in newtons.
    ///
    /// # Errors
    /// As [`DrivenModel::settle`].
    pub fn settle_under(&mut self, tensions_n: &[f64]) -> Result<(), PlantError> {
        let drives = self.tensions(tensions_n);
        self.count_command();
        solved(self.rods.settle(&|number| drives[number].clone()))
    }

    /// Moves for `duration_s` under tensions in newtons.
    ///
    /// # Errors
    /// As [`DrivenModel::settle`].
    pub fn advance_under(&mut self, tensions_n: &[f64], duration_s: f64) -> Result<(), PlantError> {
        let drives = self.tensions(tensions_n);
        self.count_command();
        solved(self.rods.advance_with(&|number, _| drives[number].clone(), &|_| duration_s))
    }

    /// The observation at `time_s`, without noise; for a following tendon it reports the drive
    /// position.
    pub fn observation(&self, commands: &[TendonCommand], time_s: f64) -> Observation {
        let following = self.rod().following_pulls_m();
        let pulls_m = commands
            .iter()
            .zip(following)
            .map(|(command, following)| command.pull_m_or(following))
            .collect();
        let mut seen = Observation { time_s, pulls_m, ..posture(self.rod(), &self.places[0]) };
        self.effects[0].iter().for_each(|effect| effect.observe(&mut seen));
        seen
    }

    /// Derivative of the measured tip with respect to each variable, per unit of it.
    pub fn tip_rates(&self) -> Vec<TipRate> {
        self.pose_rates().into_iter().map(|rates| rates.tip).collect()
    }

    /// Derivatives of the measured tip and of every tracked point with respect to each variable,
    /// per unit of it; not a number where none leads across the last command.
    pub fn pose_rates(&self) -> Vec<PoseRates> {
        if self.perturbations.is_empty() {
            return Vec::new();
        }
        let measured = |number: usize, rod: &Rod| {
            let places = &self.places[number];
            let mut seen = posture(rod, places);
            self.effects[number].iter().for_each(|effect| effect.observe(&mut seen));
            let turns = std::iter::once(places.tip(rod).1)
                .chain(places.points(rod).into_iter().map(|(_, turn)| turn));
            let positions = seen.positions_m().map(|position_m| Vector3::from(*position_m));
            positions.zip(turns).collect::<Vec<MeasuredPose>>()
        };
        let unperturbed = measured(0, self.rod());
        let rate = |(number, (perturbation, rod)): (usize, (&Perturbation, &Rod))| {
            let step = if self.rods.lost()[number] { f64::NAN } else { perturbation.step };
            let between =
                |((here_m, turn), (there_m, turned)): (&MeasuredPose, MeasuredPose)| TipRate {
                    position_m: (there_m - here_m) / step,
                    rotation_rad: rotation::log(&(turned * turn.transpose())) / step,
                };
            let mut rates: Vec<TipRate> =
                unperturbed.iter().zip(measured(number + 1, rod)).map(between).collect();
            PoseRates { tip: rates.remove(0), points: rates }
        };
        self.perturbations.iter().zip(self.rods.others()).enumerate().map(rate).collect()
    }

    /// Counts a command that is about to be carried out.
    fn count_command(&mut self) {
        self.rods.forget_lost();
        self.next = Some(self.next.map_or(0, |number| number + 1));
    }

    /// The rod of the model and its followers.
    fn each_rod(&self) -> impl Iterator<Item = &Rod> {
        std::iter::once(self.rods.leader()).chain(self.rods.others())
    }

    /// Requested displacements of each rod, metres; a following drive stays where the shape has
    /// moved it.
    fn requested_m(&self, commands: &[TendonCommand]) -> Result<Vec<Vec<f64>>, PlantError> {
        let tendons = self.rod().params().tendons.len();
        if commands.len() != tendons {
            return Err(PlantError::Refused(format!(
                "{} tendons, expected {tendons}",
                commands.len()
            )));
        }
        let follows = commands.contains(&TendonCommand::Follow);
        let requested = |(rod, shift): (&Rod, Option<(usize, f64)>)| {
            let following = if follows { rod.following_pulls_m() } else { vec![0.0; tendons] };
            let pull =
                |(tendon, (command, following)): (usize, (&TendonCommand, f64))| match *command {
                    TendonCommand::Pull(pull) => {
                        pull + shift.filter(|shift| shift.0 == tendon).map_or(0.0, |shift| shift.1)
                    }
                    TendonCommand::Follow => following,
                };
            commands.iter().zip(following).enumerate().map(pull).collect()
        };
        let shifts = std::iter::once(None).chain(
            self.perturbations
                .iter()
                .map(|perturbation| perturbation.shift(self.next, &self.drive_displacements)),
        );
        Ok(self.each_rod().zip(shifts).map(requested).collect())
    }

    /// Updates the positions of following drives from the shapes.
    fn follow(&mut self, commands: &[TendonCommand]) {
        if !commands.contains(&TendonCommand::Follow) {
            return;
        }
        let following: Vec<Vec<f64>> = self.each_rod().map(Rod::following_pulls_m).collect();
        for (drive_state, following) in self.drive_states.iter_mut().zip(following) {
            for (i, _) in commands
                .iter()
                .enumerate()
                .filter(|(_, command)| **command == TendonCommand::Follow)
            {
                (drive_state.commanded_m[i], drive_state.actual_m[i]) =
                    (following[i], following[i]);
            }
        }
    }

    /// For each rod, the tensions as drives.
    fn tensions(&self, tensions_n: &[f64]) -> Vec<Vec<Drive>> {
        let shifts = std::iter::once(None).chain(
            self.perturbations
                .iter()
                .map(|perturbation| perturbation.shift(self.next, &self.drive_displacements)),
        );
        let each = shifts.map(|shift| {
            let drive = |(tendon, &tension): (usize, &f64)| match shift {
                Some((shifted, step)) if shifted == tendon => Drive::Tension(tension + step),
                _ => Drive::Tension(tension),
            };
            tensions_n.iter().enumerate().map(drive).collect()
        });
        each.collect()
    }
}

/// The observation of a rod, without effects.
fn posture(rod: &Rod, places: &TrackedPlaces) -> Observation {
    let tip = seen_point(places.tip(rod));
    Observation {
        time_s: 0.0,
        tip_m: tip.position_m,
        tip_quaternion: tip.quaternion,
        points: places.points(rod).into_iter().map(seen_point).collect(),
        pulls_m: Vec::new(),
        tensions_n: Some(rod.tensions_n().to_vec()),
        valid: true,
    }
}

fn solved(status: SolveStatus) -> Result<(), PlantError> {
    if status == SolveStatus::Converged {
        Ok(())
    } else {
        Err(PlantError::Solver(status.name().into()))
    }
}
