//! Minimisers.

mod bfgs;
mod dense;

pub use bfgs::{Bfgs, Minimum, Objective, Stop, minimise};
