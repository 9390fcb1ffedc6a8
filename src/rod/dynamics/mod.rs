//! Motion: implicit Runge–Kutta steps of controlled error.

pub(crate) mod motion_check;
pub(crate) mod time_stepping;
