//! Minimisers.

mod bfgs;
mod lbfgs;
pub mod least_squares;
mod quadratic;

pub use bfgs::{Bfgs, Minimum, Objective, Stop, minimise};
pub use lbfgs::Lbfgs;

/// Each component of the gradient at `at`: as the function gives it, and by central differences of
/// its values.
#[cfg(test)]
pub(crate) fn both_gradients(objective: &mut dyn Objective, at: &[f64]) -> Vec<[f64; 2]> {
    let mut gradient = vec![0.0; at.len()];
    objective.value(at);
    objective.gradient(&mut gradient);
    let mut moved = |k: usize, by: f64| {
        let mut x = at.to_vec();
        x[k] += by;
        objective.value(&x)
    };
    let difference =
        |(k, analytic): (usize, f64)| [analytic, (moved(k, 1e-5) - moved(k, -1e-5)) / 2e-5];
    gradient.into_iter().enumerate().map(difference).collect()
}
