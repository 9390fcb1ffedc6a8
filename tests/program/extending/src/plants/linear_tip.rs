//! A robot whose tip follows its tendons linearly and at once, for trying out controllers.

use serde::{Deserialize, Serialize};

use super::PlantOptions;
use crate::base::{BadOption, Observation, Plant, PlantError, Seed, TendonCommand};

/// Tendons at 0°, 90°, 180° and 270°.
const TENDONS: usize = 4;
/// Height of the tip, metres.
const TIP_Z_M: f64 = 0.22;

/// Options of the linear robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LinearTipOptions {
    /// Displacement of the tip per displacement of an opposite pair of tendons.
    pub gain: f64,
}

impl Default for LinearTipOptions {
    fn default() -> Self {
        LinearTipOptions { gain: 5.0 }
    }
}

impl PlantOptions for LinearTipOptions {
    fn check(&self) -> Result<(), (String, BadOption)> {
        BadOption::unless_positive("gain", self.gain).map_err(|error| (String::new(), error))
    }

    fn tendons(&self) -> usize {
        TENDONS
    }

    fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String> {
        Ok(Box::new(LinearTip {
            gain: self.gain,
            step_s,
            time_s: 0.0,
            pulls_m: vec![0.0; TENDONS],
        }))
    }

    fn example() -> Option<Self> {
        Some(LinearTipOptions::default())
    }
}

struct LinearTip {
    gain: f64,
    step_s: f64,
    time_s: f64,
    pulls_m: Vec<f64>,
}

impl LinearTip {
    fn observe(&self) -> Observation {
        let towards =
            |near: usize, far: usize| 0.5 * self.gain * (self.pulls_m[near] - self.pulls_m[far]);
        Observation {
            time_s: self.time_s,
            tip_m: [towards(0, 2), towards(1, 3), TIP_Z_M],
            tip_quaternion: None,
            points: Vec::new(),
            pulls_m: self.pulls_m.clone(),
            tensions_n: None,
            valid: true,
        }
    }
}

impl Plant for LinearTip {
    fn tendons(&self) -> usize {
        TENDONS
    }

    fn step_s(&self) -> f64 {
        self.step_s
    }

    fn reset(&mut self, _seed: Seed) -> Result<Observation, PlantError> {
        self.pulls_m.fill(0.0);
        self.time_s = 0.0;
        Ok(self.observe())
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        if commands.len() != TENDONS {
            return Err(PlantError::Refused(format!(
                "{} tendons, expected {TENDONS}",
                commands.len()
            )));
        }
        for (tendon, command) in commands.iter().enumerate() {
            match *command {
                TendonCommand::Pull(pull_m) if pull_m.is_finite() => self.pulls_m[tendon] = pull_m,
                TendonCommand::Pull(_) => {
                    return Err(PlantError::Refused("a pull that is not finite".into()));
                }
                // Without slack and without tension it mirrors the opposite tendon.
                TendonCommand::Follow => {
                    self.pulls_m[tendon] = -self.pulls_m[(tendon + 2) % TENDONS]
                }
            }
        }
        self.time_s += self.step_s;
        Ok(self.observe())
    }
}
