//! Things that move.

mod constant_curvature;
mod simulated;

pub use constant_curvature::{ConstantCurvature, ConstantCurvatureOptions};
pub use simulated::{Simulated, SimulatedOptions};

use crate::base::Plant;

/// One line of the registry: contract tests run over all of them.
pub struct PlantEntry {
    /// Name in specs.
    pub name: &'static str,
    /// Builds an instance with default settings.
    pub example: fn() -> Box<dyn Plant>,
}

/// Every plant.
pub static REGISTRY: &[PlantEntry] = &[constant_curvature::ENTRY, simulated::ENTRY];
