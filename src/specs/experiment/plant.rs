//! The robot of a spec.

use crate::base::{BadOption, Plant, Seed};
use crate::effects::{EffectSpec, Model};
use crate::plants::{
    ConstantCurvature, ConstantCurvatureOptions, Hardware, HardwareOptions, Replay, ReplayOptions, Simulated,
    SimulatedOptions,
};
use crate::specs::document::path::KeyPath;
use serde::{Deserialize, Serialize};

/// A robot: the model, or the robot that stands for the real one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PlantSpec {
    /// The Cosserat rod with the effects of a model file.
    Simulated(Box<SimulatedSpec>),
    /// A robot of constant curvature, for tests.
    ConstantCurvature(ConstantCurvatureOptions),
    /// A real robot, or a rehearsal of one.
    Hardware(Box<HardwareOptions>),
    /// The motion of a robot in a recording.
    Replay(ReplayOptions),
}

/// A simulated robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulatedSpec {
    /// The model of the robot; in a spec, the name of a model file.
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
    /// Paths below `plant` at which the names of model files are allowed.
    pub(in crate::specs) fn model_paths(plant: &KeyPath) -> Vec<KeyPath> {
        let hardware = plant.key("hardware");
        vec![plant.key("simulated").key("model"), hardware.key("model"), hardware.key("rehearsal").key("model")]
    }

    /// Name of the kind of robot in specs.
    pub fn kind(&self) -> &'static str {
        match self {
            PlantSpec::Simulated(_) => "simulated",
            PlantSpec::ConstantCurvature(_) => "constant_curvature",
            PlantSpec::Hardware(_) => "hardware",
            PlantSpec::Replay(_) => "replay",
        }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// Path of the mapping with the first field out of range, and the field.
    pub fn check(&self) -> Result<(), (String, BadOption)> {
        match self {
            PlantSpec::ConstantCurvature(options) => {
                ConstantCurvature::new(*options).map(|_| ()).map_err(|error| ("constant_curvature".to_owned(), error))
            }
            PlantSpec::Simulated(spec) => {
                spec.options(1.0).check().map_err(|error| ("simulated".to_owned(), error))?;
                spec.model.check().map_err(|(path, error)| (format!("simulated.model.{path}"), error))
            }
            PlantSpec::Hardware(options) => {
                let below = |path: String| if path.is_empty() { "hardware".into() } else { format!("hardware.{path}") };
                options.check().map_err(|(path, error)| (below(path), error))
            }
            PlantSpec::Replay(options) => options.check().map_err(|error| ("replay".to_owned(), error)),
        }
    }

    /// Number of tendons.
    pub fn tendons(&self) -> usize {
        match self {
            PlantSpec::ConstantCurvature(_) | PlantSpec::Hardware(_) => 4,
            PlantSpec::Simulated(spec) => spec.model.robot.tendons.angles_deg.len(),
            PlantSpec::Replay(options) => options.tendons,
        }
    }

    /// Whether effects can be added to the robot.
    pub fn takes_effects(&self) -> bool {
        matches!(self, PlantSpec::Simulated(_) | PlantSpec::Hardware(_))
    }

    /// The robot, moving in steps of `step_s` seconds. A real robot is waited for until no other stage uses it.
    ///
    /// # Errors
    /// A message for a setting out of range or a device that is not as expected.
    pub fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String> {
        match self {
            PlantSpec::ConstantCurvature(options) => {
                let options = ConstantCurvatureOptions { step_s, ..*options };
                Ok(Box::new(ConstantCurvature::new(options).map_err(|error| error.to_string())?))
            }
            PlantSpec::Simulated(spec) => Ok(Box::new(Simulated::new(&spec.model, &[], spec.options(step_s)))),
            PlantSpec::Hardware(options) => Ok(Box::new(Hardware::open(options, step_s, Seed(0))?)),
            PlantSpec::Replay(options) => {
                Ok(Box::new(Replay::open(options, step_s).map_err(|error| error.to_string())?))
            }
        }
    }

    /// The same robot without measurement noise.
    #[must_use]
    pub fn without_noise(&self) -> PlantSpec {
        let mut plant = self.clone();
        match &mut plant {
            PlantSpec::ConstantCurvature(options) => options.noise_m = 0.0,
            PlantSpec::Simulated(spec) => spec.noise_m = 0.0,
            // Only a rehearsal can be measured without noise.
            PlantSpec::Hardware(options) => options.rehearsal.iter_mut().for_each(|rehearsal| rehearsal.noise_m = 0.0),
            PlantSpec::Replay(_) => {}
        }
        plant
    }

    /// The same robot with further effects, if effects can be added to it.
    #[must_use]
    pub fn with_effects(&self, effects: &[EffectSpec]) -> PlantSpec {
        let mut plant = self.clone();
        match &mut plant {
            PlantSpec::Simulated(spec) => spec.model.effects.extend_from_slice(effects),
            PlantSpec::Hardware(options) => options.attached.extend_from_slice(effects),
            PlantSpec::ConstantCurvature(_) | PlantSpec::Replay(_) => {}
        }
        plant
    }
}
