//! Which robot a spec names.

use crate::base::{BadOption, Plant};
use crate::plants::{ConstantCurvature, ConstantCurvatureOptions};
use serde::{Deserialize, Serialize};

/// A robot: the model, or what stands for the real one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PlantSpec {
    /// A robot of constant curvature, for tests and smoke runs.
    ConstantCurvature(ConstantCurvatureOptions),
}

impl PlantSpec {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        match self {
            PlantSpec::ConstantCurvature(options) => ConstantCurvature::new(*options).map(|_| ()),
        }
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
        }
    }

    /// The same robot, measured without noise.
    #[must_use]
    pub fn without_noise(&self) -> PlantSpec {
        match self {
            PlantSpec::ConstantCurvature(options) => {
                PlantSpec::ConstantCurvature(ConstantCurvatureOptions { noise_m: 0.0, ..*options })
            }
        }
    }

    /// The same robot with further effects.
    #[must_use]
    pub fn with_effects(&self, _effects: &[EffectSpec]) -> PlantSpec {
        self.clone()
    }
}

/// An effect by name with its parameters.
pub type EffectSpec = std::collections::BTreeMap<String, f64>;
