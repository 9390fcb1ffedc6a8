//! The dynamic tendon-driven Cosserat rod with a compressible spine and tendon-length control (paper, section III).
//!
//! The unknowns are the internal moments and forces along the rod, as polynomials, and the tendon tensions; the
//! derivation is in `docs/rod.md`.

mod advance;
mod basis;
mod blend;
mod conditions;
mod damping;
mod estimate;
mod fields;
mod grid;
mod jacobian;
mod loads;
mod memory;
mod motion;
mod nearby;
mod params;
mod rates;
mod reconstruction;
mod refine;
mod relax;
mod rest;
mod scheme;
mod section;
mod sensitivity;
mod shape;
mod simulation;
mod solver;
mod span;
mod stability;
mod state;
mod status;
mod system;
mod tendon;
mod trace;
mod transfer;
mod triple;
mod variation;

pub use fields::Energy;
pub use memory::{HistoryMoment, MemoryState, MomentLaw};
pub use nearby::{Nearby, NotNearby};
pub use params::{CompressibleSection, LineLoad, PointLoad, PointMass, Resolution, RodParams, TipLoad};
pub use scheme::Scheme;
pub use sensitivity::{Direction, TipRate};
pub use simulation::{Drive, Effort, Rod};
pub use span::{Span, Taper};
pub use state::CrossSection;
pub use status::Status;
pub use tendon::{PathPoint, Tendon, TendonPath};
