//! Value types that every room speaks, and the tree of seeds.

mod observation;
mod rows;
mod seed;
mod traits;

pub use observation::{Displacements, Observation, Point3, distance_m};
pub use rows::Rows;
pub use seed::Seed;
pub use traits::{Action, Plant, PlantError, Policy, PolicyError, TendonCommand};
