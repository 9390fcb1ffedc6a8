//! All that is on disk.

mod cells;
mod csv;
mod error;
mod file;
pub mod findings;
pub mod motive;
pub mod recording;
pub mod rows;
mod sheet;
pub mod tables;
mod together;

pub use error::DataError;
pub use file::write_atomic;
pub use recording::{Actuation, Recording};
pub use together::write_together;
