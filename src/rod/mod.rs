//! The dynamic tendon-driven Cosserat rod with a compressible spine and tendon-length control
//! (paper, section III).
//!
//! The unknowns are the internal moments and forces along the rod, as polynomials, and the tendon
//! tensions; the derivation is in `docs/method/rod.md`.

mod discretisation;
mod dynamics;
mod equations;
mod params;
mod sensitivity;
mod solver;
mod stability;
mod state;
mod statics;

pub use equations::contact::{ContactSum, HomePenetration};
pub use params::contact::{ContactSurface, DiskSurface};
pub use params::hysteresis_law::{HistoryMoment, HistoryState, MomentLaw};
pub use params::loads::{LineLoad, PointLoad, TipWrench};
pub use params::obstacle::{Obstacle, ObstacleShape};
pub use params::resolution::Resolution;
pub use params::rod_params::RodParams;
pub use params::scheme::Scheme;
pub use params::span::{Span, Taper};
pub use params::spine::{CompressibleSection, PointMass};
pub use params::tendon::{PRESLIDING_M, PathPoint, Tendon, TendonPath};
pub use sensitivity::perturbed_rods::{NotPerturbable, PerturbedRods};
pub use sensitivity::tip_jacobian::{Direction, PoseRates, TipRate};
pub use solver::status::SolveStatus;
pub use state::branch::RestBranch;
pub use state::fields::CrossSection;
pub use state::fields::Energy;
pub use state::readout::Effort;
pub use state::rod::{Drive, Rod};
pub use state::self_contact::SelfContact;
pub use state::tension_split::TensionSplit;
