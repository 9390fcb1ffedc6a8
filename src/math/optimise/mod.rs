//! Minimisers.

mod bfgs;
mod lbfgs;
pub mod least_squares;
mod quadratic;

pub use bfgs::{Bfgs, Minimum, Objective, Stop, minimise};
pub use lbfgs::Lbfgs;
