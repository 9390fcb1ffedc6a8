//! The [`Rod`](rod::Rod) and its state between solves.

pub(crate) mod branch;
pub(crate) mod fields;
pub(crate) mod grid_level;
pub(crate) mod rates;
pub(crate) mod readout;
pub(crate) mod regrid;
pub(crate) mod rest;
pub(crate) mod rod;
pub(crate) mod rod_state;
pub(crate) mod self_contact;
pub(crate) mod solve_log;
pub(crate) mod stage;
pub(crate) mod step_size;
pub(crate) mod tension_split;
