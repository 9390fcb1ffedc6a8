//! The dynamic tendon-driven Cosserat rod with a compressible spine and tendon-length control (paper, section III).
//!
//! The unknowns are the internal moments and forces along the rod, as polynomials, and the tendon tensions; the
//! derivation is in `docs/rod.md`.

mod params;
mod state;
mod discretisation;
mod dynamics;
mod equations;
mod sensitivity;
mod solver;
mod statics;

pub use self::params::scheme::Scheme;
pub use self::params::hysteresis_law::{HistoryMoment, MemoryState, MomentLaw};
pub use self::state::fields::Energy;
pub use self::params::rod_params::{CompressibleSection, LineLoad, PointLoad, PointMass, Resolution, RodParams, TipLoad};
pub use sensitivity::perturbed_rods::{Nearby, NotNearby};
pub use sensitivity::{Direction, TipRate};
pub use self::state::rod::{Drive, Effort, Rod};
pub use self::params::span::{Span, Taper};
pub use self::state::rod_state::CrossSection;
pub use self::solver::status::Status;
pub use self::params::tendon::{PathPoint, Tendon, TendonPath};
