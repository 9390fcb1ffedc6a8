//! Commands between recordings and models: import, export, simulate, calibrate, discover.

pub(super) mod calibrate;
pub(super) mod discover;
pub(super) mod effects;
pub(super) mod export;
pub(super) mod import;
pub(super) mod import_map;
pub(super) mod simulate;
