//! Box-constrained BFGS for few unknowns and an expensive function.
//!
//! Nocedal & Wright, Numerical Optimization, 2006: Hessian approximation B by damped BFGS
//! (procedure 18.2), each step the minimum of the quadratic model within the box (section 16.5),
//! shortened until it decreases enough (Armijo). The gradient is evaluated only at accepted steps.
//! B starts from the function's own estimate of its curvature where it has one.

use super::quadratic::minimise_quadratic;
use crate::base::interruption_point;

/// Share of the decrease along the slope that a step must reach: the usual c₁ (Nocedal & Wright,
/// section 3.1).
const ARMIJO: f64 = 1e-4;
/// Shortenings of a step after which no shorter one helps: converged to rounding.
const MAX_SHORTENINGS: usize = 30;

/// A function to minimise.
pub trait Objective {
    /// Value at `x`; infinite where it is not defined.
    fn value(&mut self, x: &[f64]) -> f64;
    /// Gradient at the point of the latest [`Objective::value`].
    fn gradient(&mut self, out: &mut [f64]);
    /// A positive definite estimate of the Hessian there (row-major), where a cheap one exists.
    fn curvature(&mut self) -> Option<Vec<f64>> {
        None
    }
}

/// Limits of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Bfgs {
    /// Lower and upper bound of each unknown.
    pub bounds: Vec<(f64, f64)>,
    /// The search ends when the quadratic model predicts a smaller decrease than this.
    pub tolerance: f64,
    /// Most evaluations of the function.
    pub max_evaluations: usize,
    /// Longest step in any unknown.
    pub max_step: f64,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The predicted decrease is below the tolerance.
    Converged,
    /// No shorter step decreased the function: converged to rounding.
    NoDecrease,
    /// The evaluation limit is reached.
    Evaluations,
    /// The function is not defined at the start.
    BadStart,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// The point.
    pub x: Vec<f64>,
    /// The value there.
    pub value: f64,
    /// Approximate Hessian there, row-major.
    pub hessian: Vec<f64>,
    /// Evaluations of the function.
    pub evaluations: usize,
    /// Why it ended.
    pub stop: Stop,
}

/// Minimises `objective` from `start`.
pub fn minimise(objective: &mut dyn Objective, start: &[f64], limits: &Bfgs) -> Minimum {
    let n = start.len();
    let x: Vec<f64> = start.iter().zip(&limits.bounds).map(|(x, b)| x.clamp(b.0, b.1)).collect();
    let value = objective.value(&x);
    let mut current =
        Minimum { x, value, hessian: Vec::new(), evaluations: 1, stop: Stop::BadStart };
    if !value.is_finite() {
        return current;
    }
    let mut gradient = vec![0.0; n];
    objective.gradient(&mut gradient);
    let estimate = objective.curvature();
    let mut is_first = estimate.is_none();
    current.hessian = estimate.unwrap_or_else(|| first_hessian(&gradient));
    loop {
        let Some((step, predicted_decrease)) = direction(&current, &gradient, limits) else {
            current.hessian = first_hessian(&gradient);
            continue;
        };
        if predicted_decrease < limits.tolerance {
            current.stop = Stop::Converged;
            return current;
        }
        let Some((x, value)) = search(objective, &mut current, &gradient, &step, limits) else {
            return current;
        };
        let mut new_gradient = vec![0.0; n];
        objective.gradient(&mut new_gradient);
        let s: Vec<f64> = x.iter().zip(&current.x).map(|(a, b)| a - b).collect();
        let y: Vec<f64> = new_gradient.iter().zip(&gradient).map(|(a, b)| a - b).collect();
        update(&mut current.hessian, &s, &y, is_first);
        is_first = false;
        (current.x, current.value, gradient) = (x, value, new_gradient);
    }
}

/// A multiple of the identity whose first step has length 1.
fn first_hessian(gradient: &[f64]) -> Vec<f64> {
    let n = gradient.len();
    let norm = gradient.iter().map(|g| g * g).sum::<f64>().sqrt().max(1e-12);
    (0..n * n).map(|i| if i % (n + 1) == 0 { norm } else { 0.0 }).collect()
}

/// The step that minimises the quadratic model within the box and the longest step, and the
/// decrease that the model promises for it; `None` when the approximation is no longer positive
/// definite.
fn direction(current: &Minimum, gradient: &[f64], limits: &Bfgs) -> Option<(Vec<f64>, f64)> {
    let n = gradient.len();
    let room: Vec<(f64, f64)> = (current.x.iter().zip(&limits.bounds))
        .map(|(x, (low, high))| ((low - x).max(-limits.max_step), (high - x).min(limits.max_step)))
        .collect();
    let step = minimise_quadratic(&current.hessian, gradient, &room)?;
    let curved = |i: usize| (0..n).map(|j| current.hessian[i * n + j] * step[j]).sum::<f64>();
    let predicted_decrease: f64 = (0..n).map(|i| -step[i] * (gradient[i] + 0.5 * curved(i))).sum();
    (predicted_decrease >= 0.0).then_some((step, predicted_decrease))
}

/// Shortens the step until the function decreases enough; sets `current.stop` and returns `None`
/// otherwise.
fn search(
    objective: &mut dyn Objective,
    current: &mut Minimum,
    gradient: &[f64],
    step: &[f64],
    limits: &Bfgs,
) -> Option<(Vec<f64>, f64)> {
    let mut length = 1.0_f64;
    for _ in 0..MAX_SHORTENINGS {
        if current.evaluations >= limits.max_evaluations {
            current.stop = Stop::Evaluations;
            return None;
        }
        let x: Vec<f64> = (0..step.len())
            .map(|i| {
                length.mul_add(step[i], current.x[i]).clamp(limits.bounds[i].0, limits.bounds[i].1)
            })
            .collect();
        let slope: f64 = (0..x.len()).map(|i| gradient[i] * (x[i] - current.x[i])).sum();
        interruption_point();
        let value = objective.value(&x);
        current.evaluations += 1;
        if value <= current.value + ARMIJO * slope && slope < 0.0 {
            return Some((x, value));
        }
        // The minimum of the parabola through both values and the slope, kept within a tenth and a
        // half.
        let curvature = value - current.value - slope;
        let shorter =
            if curvature.is_finite() && curvature > 0.0 { -0.5 * slope / curvature } else { 0.1 };
        length *= shorter.clamp(0.1, 0.5);
    }
    current.stop = Stop::NoDecrease;
    None
}

/// Damped BFGS update of B (Nocedal & Wright, procedure 18.2); the first one rescales B to the
/// curvature seen.
fn update(b: &mut [f64], s: &[f64], y: &[f64], is_first: bool) {
    let n = s.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let sy = dot(s, y);
    if is_first && sy > 0.0 {
        let scale = dot(y, y) / sy;
        b.fill(0.0);
        b.iter_mut().step_by(n + 1).for_each(|diagonal| *diagonal = scale);
    }
    let bs: Vec<f64> = (0..n).map(|i| dot(&b[i * n..(i + 1) * n], s)).collect();
    let sbs = dot(s, &bs);
    if sbs <= 0.0 {
        return;
    }
    // Powell's damping keeps B positive definite.
    let theta = if sy >= 0.2 * sbs { 1.0 } else { 0.8 * sbs / (sbs - sy) };
    let r: Vec<f64> = (0..n).map(|i| theta * y[i] + (1.0 - theta) * bs[i]).collect();
    let sr = dot(s, &r);
    for i in 0..n {
        for j in 0..n {
            b[i * n + j] += r[i] * r[j] / sr - bs[i] * bs[j] / sbs;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Rosenbrock([f64; 2]);
    impl Objective for Rosenbrock {
        fn value(&mut self, x: &[f64]) -> f64 {
            self.0 = [x[0], x[1]];
            (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2)
        }
        fn gradient(&mut self, out: &mut [f64]) {
            let [a, b] = self.0;
            out[0] = -2.0 * (1.0 - a) - 400.0 * a * (b - a * a);
            out[1] = 200.0 * (b - a * a);
        }
    }

    fn limits(bounds: [(f64, f64); 2]) -> Bfgs {
        Bfgs { bounds: bounds.to_vec(), tolerance: 1e-14, max_evaluations: 200, max_step: 2.0 }
    }

    #[test]
    fn finds_the_valley_floor() {
        let found = minimise(&mut Rosenbrock([0.0; 2]), &[-1.2, 1.0], &limits([(-5.0, 5.0); 2]));
        assert_eq!(found.stop, Stop::Converged);
        assert!((found.x[0] - 1.0).abs() < 1e-6 && (found.x[1] - 1.0).abs() < 1e-6, "{found:?}");
        assert!(found.evaluations < 60, "{}", found.evaluations);
    }

    #[test]
    fn stays_in_the_box() {
        // On x ≤ 0.5 the minimum is at x = 0.5, y = 0.25.
        let found =
            minimise(&mut Rosenbrock([0.0; 2]), &[-1.2, 1.0], &limits([(-5.0, 0.5), (-5.0, 5.0)]));
        assert!((found.x[0] - 0.5).abs() < 1e-9 && (found.x[1] - 0.25).abs() < 1e-6, "{found:?}");
    }

    struct Quadratic([f64; 2], bool);
    impl Objective for Quadratic {
        fn value(&mut self, x: &[f64]) -> f64 {
            self.0 = [x[0], x[1]];
            500.0 * (x[0] - 1.0).powi(2) + 0.5 * (x[1] - 2.0).powi(2)
        }
        fn gradient(&mut self, out: &mut [f64]) {
            out.copy_from_slice(&[1000.0 * (self.0[0] - 1.0), self.0[1] - 2.0]);
        }
        fn curvature(&mut self) -> Option<Vec<f64>> {
            self.1.then(|| vec![1000.0, 0.0, 0.0, 1.0])
        }
    }

    #[test]
    fn a_known_curvature_makes_newton_steps() {
        let box_ = limits([(-5.0, 5.0); 2]);
        let newton = minimise(&mut Quadratic([0.0; 2], true), &[0.0, 0.5], &box_);
        let blind = minimise(&mut Quadratic([0.0; 2], false), &[0.0, 0.5], &box_);
        assert_eq!((newton.evaluations, newton.stop), (2, Stop::Converged));
        assert!(blind.evaluations > 3 && (blind.x[1] - 2.0).abs() < 1e-6);
        assert_eq!(
            minimise(&mut Quadratic([0.0; 2], true), &[f64::NAN, 0.0], &box_).stop,
            Stop::BadStart
        );
    }
}
