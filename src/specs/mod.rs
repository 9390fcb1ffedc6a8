//! Experiments as YAML: strictly checked, with the file, line and key of whatever is wrong.

mod document;
mod emit;
mod error;
mod locate;
mod path;
mod suggest;
mod wording;

pub use document::Document;
pub use error::{Place, SpecError};
pub use locate::{End, locate};
pub use path::{KeyPath, Step};
mod claims;
pub use claims::{Axis, Claim, Metric, ReachCell, Relation, Size};
