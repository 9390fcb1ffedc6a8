//! The dynamic tendon-driven Cosserat rod with a compressible spine and tendon-length control (paper, section III).
//!
//! The unknowns are the internal moments and forces along the rod, as polynomials, and the tendon tensions; the
//! derivation is in `docs/rod.md`.

mod discretisation;
mod dynamics;
mod equations;
mod fields;
mod params;
mod sensitivity;
mod simulation;
mod solver;
mod span;
mod state;
mod statics;
mod status;
mod tendon;

pub use dynamics::scheme::Scheme;
pub use equations::hysteresis_law::{HistoryMoment, MemoryState, MomentLaw};
pub use fields::Energy;
pub use params::{CompressibleSection, LineLoad, PointLoad, PointMass, Resolution, RodParams, TipLoad};
pub use sensitivity::perturbed_rods::{Nearby, NotNearby};
pub use sensitivity::{Direction, TipRate};
pub use simulation::{Drive, Effort, Rod};
pub use span::{Span, Taper};
pub use state::CrossSection;
pub use status::Status;
pub use tendon::{PathPoint, Tendon, TendonPath};
