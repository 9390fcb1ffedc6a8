//! All that is on disk.

pub mod rows;
