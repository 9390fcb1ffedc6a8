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
}

pub(super) const ENTRY: PlantEntry = PlantEntry {
    name: "simulated",
    example: || Box::new(Simulated::new(&Model::default(), &[], SimulatedOptions::default())),
};

impl Simulated {
    /// A robot that follows a checked model, with `extra` effects (such as a load for some trials) on top.
    pub fn new(model: &Model, extra: &[EffectSpec], options: SimulatedOptions) -> Simulated {
        Simulated {
            rod: Rod::new(model.rod(extra)),
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
        let drives = self.drives(commands, f64::INFINITY)?;
        solved(self.rod.settle(&drives))?;
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

    /// Applies the effects on the drives to a command that is held for `dt_s` seconds (infinite: until all is at rest).
    fn drives(&mut self, commands: &[TendonCommand], dt_s: f64) -> Result<Vec<Drive>, PlantError> {
        if commands.len() != self.tendons() {
            return Err(PlantError::Refused(format!("{} tendons, expected {}", commands.len(), self.tendons())));
        }
        let mut pulls: Vec<f64> = Vec::with_capacity(commands.len());
        // A drive that follows stands where the shape has taken it; the effects' histories go on from there.
        let remembered = !self.effects.is_empty() && commands.contains(&TendonCommand::Follow);
        let following = if remembered { self.rod.following_pulls_m() } else { vec![0.0; commands.len()] };
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
        for effect in &mut self.effects {
            effect.command(&mut pulls, dt_s);
        }
        let drive = |(command, pull): (&TendonCommand, f64)| match command {
            TendonCommand::Pull(_) => Drive::Pull(pull),
            TendonCommand::Follow => Drive::Follow,
        };
        Ok(commands.iter().zip(pulls).map(drive).collect())
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
        // As many parts as the rod takes time steps, so that what the drives do late they do at its time.
        let parts = (self.options.step_s / 0.05 - 1e-9).ceil().max(1.0);
        let part_s = self.options.step_s / parts;
        for _ in 0..parts as u64 {
            let drives = self.drives(commands, part_s)?;
            solved(self.rod.advance(&drives, part_s))?;
        }
        self.time_s += self.options.step_s;
        Ok(self.observe(commands))
    }
}

fn solved(status: Status) -> Result<(), PlantError> {
    if status == Status::Converged { Ok(()) } else { Err(PlantError::Solver(status.name().into())) }
}
