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

pub use error::DataError;
pub use file::{write_atomic, write_together};
pub use recording::{Actuation, Recording};
