//! Limited-memory BFGS for many unknowns: Nocedal & Wright, Numerical Optimization, 2006,
//! algorithms 7.4 and 7.5, with the weak Wolfe line search of Lewis & Overton, Mathematical
//! Programming 2013, algorithm 2.6.

use std::collections::VecDeque;

/// The usual c₁ and c₂ of the Wolfe conditions (Nocedal & Wright, section 3.1).
const ARMIJO: f64 = 1e-4;
const CURVATURE: f64 = 0.9;

/// Pairs of steps and changes of the gradient that are remembered.
const MAX_PAIRS: usize = 20;

/// Most evaluations of a line search.
const MAX_EVALUATIONS: usize = 40;

/// A step and the change of the gradient along it.
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// 1 / (step · change).
    rho: f64,
}

/// A search for a minimum that is taken step by step.
pub struct Lbfgs {
    point: Vec<f64>,
    gradient: Vec<f64>,
    /// Not a number before the first step.
    value: f64,
    pairs: VecDeque<Pair>,
}

impl Lbfgs {
    /// A search that begins at `start`.
    pub fn new(start: Vec<f64>) -> Self {
        Lbfgs {
            gradient: vec![0.0; start.len()],
            point: start,
            value: f64::NAN,
            pairs: VecDeque::new(),
        }
    }

    /// Where it stands.
    pub fn point(&self) -> &[f64] {
        &self.point
    }

    /// The function's value there.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// One step; `function` gives the value at a point and writes the gradient. The length of the
    /// step as a share of the full one; `None` where no step makes the value smaller.
    pub fn step(&mut self, function: &mut impl FnMut(&[f64], &mut [f64]) -> f64) -> Option<f64> {
        if self.pairs.is_empty() && self.value.is_nan() {
            self.value = function(&self.point, &mut self.gradient);
        }
        let length = self.search(self.direction(), function);
        if length.is_none() && !self.pairs.is_empty() {
            // Old pairs may point nowhere downhill: begin again along the gradient.
            self.pairs.clear();
            return self.search(self.direction(), function);
        }
        length
    }

    /// The two-loop recursion.
    fn direction(&self) -> Vec<f64> {
        let mut direction: Vec<f64> = self.gradient.iter().map(|slope| -slope).collect();
        let mut alphas = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let alpha = pair.rho * dot(&pair.step, &direction);
            add(&mut direction, -alpha, &pair.change);
            alphas.push(alpha);
        }
        // The recursion starts from a Hessian with the curvature of the last step.
        let scale = match self.pairs.back() {
            Some(last) => 1.0 / (last.rho * dot(&last.change, &last.change)),
            None => 1.0 / dot(&self.gradient, &self.gradient).sqrt().max(1.0),
        };
        direction.iter_mut().for_each(|value| *value *= scale);
        for (pair, alpha) in self.pairs.iter().zip(alphas.into_iter().rev()) {
            let beta = pair.rho * dot(&pair.change, &direction);
            add(&mut direction, alpha - beta, &pair.step);
        }
        direction
    }

    /// Goes along `direction` as far as value and slope fall enough.
    fn search(
        &mut self,
        direction: Vec<f64>,
        function: &mut impl FnMut(&[f64], &mut [f64]) -> f64,
    ) -> Option<f64> {
        let slope = dot(&self.gradient, &direction);
        if slope.is_nan() || slope >= 0.0 {
            return None;
        }
        let (mut low, mut high, mut length) = (0.0, f64::INFINITY, 1.0);
        let mut gradient = vec![0.0; direction.len()];
        for _ in 0..MAX_EVALUATIONS {
            let mut point = self.point.clone();
            add(&mut point, length, &direction);
            let value = function(&point, &mut gradient);
            if value.is_nan() || value > self.value + ARMIJO * length * slope {
                high = length;
            } else if dot(&gradient, &direction) < CURVATURE * slope {
                low = length;
            } else {
                self.accept(point, gradient, value);
                return Some(length);
            }
            length = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * low };
        }
        None
    }

    fn accept(&mut self, point: Vec<f64>, gradient: Vec<f64>, value: f64) {
        let difference = |to: &[f64], from: &[f64]| {
            to.iter().zip(from).map(|(a, b)| a - b).collect::<Vec<f64>>()
        };
        let (step, change) =
            (difference(&point, &self.point), difference(&gradient, &self.gradient));
        let curvature = dot(&step, &change);
        // Only such pairs keep the approximation positive definite.
        if curvature > 0.0 {
            if self.pairs.len() == MAX_PAIRS {
                self.pairs.pop_front();
            }
            self.pairs.push_back(Pair { step, change, rho: 1.0 / curvature });
        }
        (self.point, self.gradient, self.value) = (point, gradient, value);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `out += scale · other`.
fn add(out: &mut [f64], scale: f64, other: &[f64]) {
    out.iter_mut().zip(other).for_each(|(out, other)| *out = other.mul_add(scale, *out));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The chained Rosenbrock function.
    fn valley(x: &[f64], slope: &mut [f64]) -> f64 {
        slope.fill(0.0);
        let mut value = 0.0;
        for i in 0..x.len() - 1 {
            let (a, b) = (1.0 - x[i], x[i + 1] - x[i] * x[i]);
            value += a * a + 100.0 * b * b;
            slope[i] -= 2.0 * a + 400.0 * x[i] * b;
            slope[i + 1] += 200.0 * b;
        }
        value
    }

    #[test]
    fn finds_the_valley_floor_of_many_unknowns() {
        let mut evaluations = 0;
        let mut counted = |x: &[f64], slope: &mut [f64]| {
            evaluations += 1;
            valley(x, slope)
        };
        let mut search = Lbfgs::new(vec![-1.2; 50]);
        let mut before = f64::INFINITY;
        while search.step(&mut counted).is_some() {
            assert!(search.value() < before);
            before = search.value();
        }
        assert!(search.point().iter().all(|x| (x - 1.0).abs() < 1e-6), "{:?}", search.point());
        assert!(evaluations < 1000, "{evaluations}");
    }

    #[test]
    fn stops_where_nothing_falls() {
        let mut search = Lbfgs::new(vec![3.0]);
        assert_eq!(
            search.step(&mut |_, slope| {
                slope[0] = 0.0;
                5.0
            }),
            None
        );
        assert_eq!(search.value(), 5.0);
    }
}
