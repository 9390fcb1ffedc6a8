//! Things that move.

mod constant_curvature;
pub mod hardware;
mod replay;
mod simulated;

pub use constant_curvature::{ConstantCurvature, ConstantCurvatureOptions};
pub use hardware::{Hardware, HardwareOptions};
pub use replay::{Replay, ReplayOptions};
pub use simulated::{Simulated, SimulatedOptions};

use crate::base::Plant;

/// One line of the registry: contract tests run over all of them.
pub struct PlantEntry {
    /// Name in specs.
    pub name: &'static str,
    /// Builds an instance with default settings.
    pub example: fn() -> Box<dyn Plant>,
}

/// Every plant that does the same each time; [`Hardware`] and [`Replay`] stand for one robot and one recording.
pub static REGISTRY: &[PlantEntry] = &[constant_curvature::ENTRY, simulated::ENTRY];
