//! Least squares, its starts and intervals.

pub(super) mod intervals;
pub(super) mod optimum;
pub(super) mod starts;
