//! Files: recordings, tables, findings, imports.

mod atomic_batch;
pub mod calibration;
mod csv;
mod error;
mod file;
pub mod findings;
pub mod import;
pub mod mcap;
pub mod packed;
pub mod recording;
mod recording_source;
mod row_serde;
pub mod scene;
mod table;
mod table_file;
mod table_row;
pub mod tables;
mod text;

pub use atomic_batch::{write_atomic, write_atomic_batch};
pub use error::DataError;
pub use recording::{Actuation, Recording};
pub use recording_source::{RecordingColumns, RecordingSource};
pub use table::Cells;
pub use table_row::{TableColumn, TableColumns, TableDescription, TableRow};
pub(crate) use table_row::{columns, table_rows};
pub use text::read_text;
