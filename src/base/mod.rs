//! Value types shared by all rooms, the plant and policy traits, and the seed tree.

mod interruption;
mod line_peer;
mod observation;
mod option;
mod outcome;
mod per_tendon;
mod processor_time;
mod rows;
mod seed;
pub mod series;
mod tendon_layout;
mod tip_model;
mod traits;
mod work_share;

pub use interruption::{InterruptRequest, Interrupted, interruption_point};
pub(crate) use line_peer::printable;
pub use line_peer::{LinePeer, PeerError};
pub use observation::{Displacements, Observation, Point3, SeenPoint, distance_m};
pub use option::BadOption;
pub use outcome::Outcome;
pub use per_tendon::PerTendon;
pub(crate) use processor_time::{counted, thread_ns, with_time_of_others};
pub use rows::Rows;
pub use seed::{Generator, Seed};
pub use tendon_layout::{PlacedTendon, TendonLayout};
pub use tip_model::{NoRestPose, RestPose, TipModel};
pub use traits::{Action, Plant, PlantError, Policy, PolicyError, TendonCommand};
pub use work_share::{report_share, with_share_listener};

/// Whether a setting has its default: specs hold those that do not.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
