//! Files: recordings, result tables, findings, imports.

mod atomic_batch;
pub mod calibration;
mod csv;
mod error;
mod file;
pub mod findings;
pub mod import;
pub mod learning_peers;
pub mod mcap;
pub mod packed;
pub mod population;
pub mod recording;
pub mod repairs;
pub mod responses;
mod row_serde;
pub mod rows;
mod table;
mod table_file;
mod table_row;
pub mod tables;
mod text;

pub use atomic_batch::{write_atomic, write_atomic_batch};
pub use error::DataError;
pub use recording::{Actuation, Recording};
pub use table_row::{TableColumn, TableDescription, TableRow};
pub use text::read_text;

/// Every table of results.
pub fn table_descriptions() -> impl Iterator<Item = &'static TableDescription> {
    let tables = rows::TABLES.iter().chain(responses::TABLES).chain(repairs::TABLES).chain(population::TABLES);
    tables.chain(findings::TABLES).chain(learning_peers::TABLES)
}
