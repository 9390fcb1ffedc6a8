//! Minimisers.

mod bfgs;
pub mod least_squares;
mod quadratic;

pub use bfgs::{Bfgs, Minimum, Objective, Stop, minimise};
