//! What several tests share. Each of the five programs uses a part of it.
#![allow(dead_code, unreachable_pub, missing_docs)]

pub mod discovery_rows;
pub mod hour;
pub mod motive;
pub mod policies;
pub mod rehearsal;
pub mod report_rows;
pub mod rods;
pub mod runs;
pub mod schema_check;
pub mod shooting;
pub mod text_overlap;
