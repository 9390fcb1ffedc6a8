//! Which robot a spec names.

use crate::base::{BadOption, Plant};
use crate::effects::{EffectSpec, Model};
use crate::plants::{ConstantCurvature, ConstantCurvatureOptions, Simulated, SimulatedOptions};
use serde::{Deserialize, Serialize};

/// A robot: the model, or what stands for the real one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PlantSpec {
    /// The Cosserat rod with the effects of a model file.
    Simulated(Box<SimulatedSpec>),
    /// A robot of constant curvature, for tests.
    ConstantCurvature(ConstantCurvatureOptions),
}

/// A simulated robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulatedSpec {
    /// What it is made of; in a spec, the name of a model file.
    pub model: Model,
    /// Standard deviation of the tracking noise per axis, metres.
    #[serde(default)]
    pub noise_m: f64,
    /// Commands beyond this displacement are refused, metres.
    #[serde(default = "travel_m")]
    pub travel_m: f64,
}

fn travel_m() -> f64 {
    SimulatedOptions::default().travel_m
}

impl SimulatedSpec {
    fn options(&self, step_s: f64) -> SimulatedOptions {
        SimulatedOptions { step_s, noise_m: self.noise_m, travel_m: self.travel_m }
    }
}

impl PlantSpec {
    /// Checks every range.
    ///
    /// # Errors
    /// The path below which the key stands, and the first field out of range.
    pub fn check(&self) -> Result<(), (String, BadOption)> {
        match self {
            PlantSpec::ConstantCurvature(options) => {
                ConstantCurvature::new(*options).map(|_| ()).map_err(|error| ("constant_curvature".to_owned(), error))
            }
            PlantSpec::Simulated(spec) => {
                spec.options(1.0).check().map_err(|error| ("simulated".to_owned(), error))?;
                spec.model.check().map_err(|(path, error)| (format!("simulated.model.{path}"), error))
            }
        }
    }

    /// Number of tendons.
    pub fn tendons(&self) -> usize {
        match self {
            PlantSpec::ConstantCurvature(_) => 4,
            PlantSpec::Simulated(spec) => spec.model.robot.tendons.angles_deg.len(),
        }
    }

    /// True for robots to which effects can be added.
    pub fn takes_effects(&self) -> bool {
        matches!(self, PlantSpec::Simulated(_))
    }

    /// The robot, moving in steps of `step_s` seconds.
    ///
    /// # Errors
    /// What is out of range, in words.
    pub fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String> {
        match self {
            PlantSpec::ConstantCurvature(options) => {
                let options = ConstantCurvatureOptions { step_s, ..*options };
                Ok(Box::new(ConstantCurvature::new(options).map_err(|error| error.to_string())?))
            }
            PlantSpec::Simulated(spec) => Ok(Box::new(Simulated::new(&spec.model, &[], spec.options(step_s)))),
        }
    }

    /// The same robot, measured without noise.
    #[must_use]
    pub fn without_noise(&self) -> PlantSpec {
        let mut plant = self.clone();
        match &mut plant {
            PlantSpec::ConstantCurvature(options) => options.noise_m = 0.0,
            PlantSpec::Simulated(spec) => spec.noise_m = 0.0,
        }
        plant
    }

    /// The same robot with further effects, where it takes any.
    #[must_use]
    pub fn with_effects(&self, effects: &[EffectSpec]) -> PlantSpec {
        let mut plant = self.clone();
        if let PlantSpec::Simulated(spec) = &mut plant {
            spec.model.effects.extend_from_slice(effects);
        }
        plant
    }
}
