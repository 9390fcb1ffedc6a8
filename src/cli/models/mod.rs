//! Commands between recordings and models: import, export, simulate, calibrate, discover.

pub(super) mod calibrate;
pub(super) mod discover;
pub(super) mod effects;
pub(super) mod export;
pub(super) mod import;
mod import_map;
pub(super) mod several;
pub(super) mod simulate;
