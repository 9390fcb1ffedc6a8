//! Minimisers.

mod bfgs;
mod quadratic;

pub use bfgs::{Bfgs, Minimum, Objective, Stop, minimise};
