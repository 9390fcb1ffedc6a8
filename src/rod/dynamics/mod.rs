//! Motion: implicit Runge–Kutta steps of controlled error.

pub(crate) mod growth;
pub(crate) mod motion_check;
mod motion_grid;
pub(crate) mod time_stepping;
