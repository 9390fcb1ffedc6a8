//! The simulated robot: the Cosserat rod with the effects of a model on it, measured by a noisy tracker.

use rand_distr::{Distribution, Normal};
use serde::{Deserialize, Serialize};

use super::PlantEntry;
use crate::base::{BadOption, Generator, Observation, Plant, PlantError, Seed, TendonCommand};
use crate::effects::{Effect, EffectSpec, Model};
use crate::math::rotation;
use crate::rod::{Drive, Rod, Status, TipLoad};

/// Settings of a simulated robot besides its model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SimulatedOptions {
    /// Duration of one control step, s.
    pub step_s: f64,
    /// Standard deviation of the tracking noise per axis, metres.
    pub noise_m: f64,
    /// Commands beyond this displacement are refused, metres.
    pub travel_m: f64,
}

impl Default for SimulatedOptions {
    fn default() -> Self {
        SimulatedOptions { step_s: 0.2, noise_m: 0.0, travel_m: 0.06 }
    }
}

impl SimulatedOptions {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("step_s", self.step_s)?;
        BadOption::unless_positive("travel_m", self.travel_m)?;
        if self.noise_m.is_finite() && self.noise_m >= 0.0 {
            return Ok(());
        }
        let found = self.noise_m.to_string();
        Err(BadOption { key: "noise_m", found, expected: "a finite number of at least 0" })
    }
}

/// A Cosserat rod as a [`Plant`].
pub struct Simulated {
    rod: Rod,
    effects: Vec<Box<dyn Effect>>,
    options: SimulatedOptions,
    time_s: f64,
    noise: Generator,
    /// Time in which the drives carry out a command, s.
    drive_time_s: f64,
    /// Displacements that the drives were last told to reach, and those that they stand at with the effects on them.
    told_m: Vec<f64>,
    stand_m: Vec<f64>,
}

pub(super) const ENTRY: PlantEntry = PlantEntry {
    name: "simulated",
    example: || Box::new(Simulated::new(&Model::default(), &[], SimulatedOptions::default())),
};

impl Simulated {
    /// A robot that follows a checked model, with `extra` effects (such as a load for some trials) on top.
    pub fn new(model: &Model, extra: &[EffectSpec], options: SimulatedOptions) -> Simulated {
        let rod = Rod::new(model.rod(extra));
        let home = vec![0.0; rod.params().tendons.len()];
        Simulated {
            rod,
            drive_time_s: model.robot.drive_time_s,
            told_m: home.clone(),
            stand_m: home,
            effects: model.effects(extra),
            options,
            time_s: 0.0,
            noise: Seed(0).rng(),
        }
    }

    /// The rod itself, for its shape, tensions and energy.
    pub fn rod(&self) -> &Rod {
        &self.rod
    }

    /// Adds a load at the tip to that of the model, from now on.
    pub fn set_extra_tip_load(&mut self, extra: TipLoad) {
        let own = self.rod.params().tip_load;
        self.rod
            .set_tip_load(TipLoad { force_n: own.force_n + extra.force_n, moment_nm: own.moment_nm + extra.moment_nm });
    }

    /// Straight, without history, tendons slack: the start of a trial that is driven by tensions.
    pub fn reset_slack(&mut self, seed: Seed) {
        self.noise = seed.child("tracking").rng();
        self.time_s = 0.0;
        self.rod.restart();
        self.effects.iter_mut().for_each(|effect| effect.reset());
    }

    /// Brings the robot to rest under `commands` instead of at home.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn settle(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        self.told_m = self.asked_m(commands)?;
        self.stand_m = self.affected(self.told_m.clone(), f64::INFINITY);
        solved(self.rod.settle(&drives(commands, &self.stand_m, &self.stand_m, 1.0)))?;
        self.follow(commands);
        Ok(self.observe(commands))
    }

    /// Puts the tendons under tensions in newtons for one step, or at rest for good when `settled`.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn apply_tensions(&mut self, tensions_n: &[f64], settled: bool) -> Result<Observation, PlantError> {
        let drives: Vec<Drive> = tensions_n.iter().map(|&tension| Drive::Tension(tension)).collect();
        if settled {
            solved(self.rod.settle(&drives))?;
        } else {
            solved(self.rod.advance(&drives, self.options.step_s))?;
            self.time_s += self.options.step_s;
        }
        Ok(self.observe(&vec![TendonCommand::Follow; tensions_n.len()]))
    }

    /// Sets the duration of the next steps, s.
    pub fn set_step_s(&mut self, step_s: f64) {
        self.options.step_s = step_s;
    }

    /// The displacements that a command asks for; a drive that follows stands where the shape has taken it.
    fn asked_m(&self, commands: &[TendonCommand]) -> Result<Vec<f64>, PlantError> {
        if commands.len() != self.tendons() {
            return Err(PlantError::Refused(format!("{} tendons, expected {}", commands.len(), self.tendons())));
        }
        let mut pulls = Vec::with_capacity(commands.len());
        let follows = commands.contains(&TendonCommand::Follow);
        let following = if follows { self.rod.following_pulls_m() } else { vec![0.0; commands.len()] };
        for (command, following) in commands.iter().zip(following) {
            match *command {
                TendonCommand::Pull(pull) if !pull.is_finite() => {
                    return Err(PlantError::Refused("a displacement that is not finite".into()));
                }
                TendonCommand::Pull(pull) if pull.abs() > self.options.travel_m => {
                    let travel = self.options.travel_m;
                    return Err(PlantError::Refused(format!("a displacement of {pull} m, travel is ±{travel} m")));
                }
                TendonCommand::Pull(pull) => pulls.push(pull),
                TendonCommand::Follow => pulls.push(following),
            }
        }
        Ok(pulls)
    }

    /// Where the drives stand, with the effects on them, `dt_s` seconds after they were last looked at, having moved to
    /// `pulls_m` in the meantime; infinite: once all is at rest.
    fn affected(&mut self, mut pulls_m: Vec<f64>, dt_s: f64) -> Vec<f64> {
        for effect in &mut self.effects {
            effect.command(&mut pulls_m, dt_s);
        }
        pulls_m
    }

    /// Moves the drives from where they stand to what `commands` ask for, and then holds them.
    fn play(&mut self, commands: &[TendonCommand]) -> Result<(), PlantError> {
        let target = self.asked_m(commands)?;
        let step_s = self.options.step_s;
        let ramp_s = self.drive_time_s.min(step_s);
        let late = self.effects.iter().any(|effect| effect.acts_late());
        let count = if late { (step_s / ramp_s - 1e-9).ceil() } else { 1.0 };
        let parts = if late { vec![step_s / count; count as usize] } else { vec![ramp_s, step_s - ramp_s] };
        let from = std::mem::replace(&mut self.told_m, target.clone());
        let mut now = 0.0;
        for part_s in parts.into_iter().filter(|part| *part > 1e-9 * step_s) {
            now += part_s;
            let share = (now / ramp_s).min(1.0);
            let asked = from.iter().zip(&target).map(|(from, to)| from + share * (to - from)).collect();
            let reached = self.affected(asked, part_s);
            let start = std::mem::replace(&mut self.stand_m, reached.clone());
            let drives = |t: f64| drives(commands, &start, &reached, t / part_s);
            solved(self.rod.advance_with(&drives, part_s))?;
        }
        self.follow(commands);
        Ok(())
    }

    /// Takes note of where the shape has taken the drives that follow it.
    fn follow(&mut self, commands: &[TendonCommand]) {
        if !commands.contains(&TendonCommand::Follow) {
            return;
        }
        let following = self.rod.following_pulls_m();
        for (i, _) in commands.iter().enumerate().filter(|(_, command)| **command == TendonCommand::Follow) {
            (self.told_m[i], self.stand_m[i]) = (following[i], following[i]);
        }
    }

    fn observe(&mut self, commands: &[TendonCommand]) -> Observation {
        let following = self.rod.following_pulls_m();
        let pull = |(command, following): (&TendonCommand, f64)| match *command {
            TendonCommand::Pull(pull) => pull,
            TendonCommand::Follow => following,
        };
        let mut seen = Observation {
            time_s: self.time_s,
            tip_m: self.rod.tip_m().into(),
            tip_quaternion: Some(rotation::to_quaternion(&self.rod.tip_rotation())),
            pulls_m: commands.iter().zip(following).map(pull).collect(),
            tensions_n: Some(self.rod.tensions_n().to_vec()),
            valid: true,
        };
        for effect in &self.effects {
            effect.observe(&mut seen);
        }
        if let Ok(normal) = Normal::new(0.0, self.options.noise_m) {
            seen.tip_m.iter_mut().for_each(|value| *value += normal.sample(&mut self.noise));
        }
        seen
    }
}

impl Plant for Simulated {
    fn tendons(&self) -> usize {
        self.rod.params().tendons.len()
    }

    fn step_s(&self) -> f64 {
        self.options.step_s
    }

    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError> {
        self.reset_slack(seed);
        self.settle(&vec![TendonCommand::Pull(0.0); self.tendons()])
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        self.play(commands)?;
        self.time_s += self.options.step_s;
        Ok(self.observe(commands))
    }
}

/// Drives that are `share` of the way between two displacements, or follow.
fn drives(commands: &[TendonCommand], from_m: &[f64], to_m: &[f64], share: f64) -> Vec<Drive> {
    let drive = |(command, (from, to)): (&TendonCommand, (&f64, &f64))| match command {
        TendonCommand::Pull(_) => Drive::Pull(from + share * (to - from)),
        TendonCommand::Follow => Drive::Follow,
    };
    commands.iter().zip(from_m.iter().zip(to_m)).map(drive).collect()
}

fn solved(status: Status) -> Result<(), PlantError> {
    if status == Status::Converged { Ok(()) } else { Err(PlantError::Solver(status.name().into())) }
}
