//! From results of stages to published files: tables, claims, figures, manifest.

pub(super) mod claims;
pub(super) mod compare;
pub(super) mod compare_runs;
pub(super) mod discovery_files;
pub(super) mod failed_cells;
mod gp_range_ends;
pub(super) mod manifest;
pub(super) mod merge;
pub(super) mod metrics;
pub(super) mod one_claim;
pub(super) mod provenance;
pub(super) mod publish_all;
pub(super) mod redraw;
pub(super) mod repair_tables;
pub(super) mod results;
pub(super) mod sweep;
pub(super) mod tables;
