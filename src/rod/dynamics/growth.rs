//! Steps short enough for what grows. Where a rod is unstable, deviations grow as exp(λt), and an
//! L-stable scheme damps them if its step is long against 1/λ: the rod would seem to rest where it
//! would not stay.

use nalgebra::Vector3;

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::stability::linearised_motion::Growth;
use crate::rod::state::rod::{Drive, Rod};
use crate::rod::state::step_size::FlutterLimit;

/// Longest step times the rate of the fastest growth, and times the frequency where an oscillation
/// grows.
const MAX_GROWTH_PER_STEP: f64 = 0.5;
const MAX_ANGLE_PER_STEP: f64 = 0.2;
/// Steps for which the eigenvalues of a growing oscillation serve.
const FLUTTER_STEPS: u32 = 10;
/// A derivative whose tangent exceeds this share of the elastic stiffness in all directions proves
/// stability also at the states near its own at which it still serves as derivative.
const SAFE_MARGIN: f64 = 0.15;

impl Rod {
    /// The longest step that growing deviations allow after the step of `h` seconds to `drives`
    /// that has just been solved, as a share of `h`: infinite where none grow, below 1 if the step
    /// was too long.
    pub(crate) fn growth_step_ratio(&mut self, drives: &dyn Fn(f64) -> Vec<Drive>, h: f64) -> f64 {
        // A derivative may serve the iteration and know nothing of a load that has come to push
        // along the rod.
        let knows_load = self.solver.differentiated_under == self.tip_load;
        // Cheapest proof first: most steps need no matrix.
        let is_stable = self.is_below_buckling()
            || (knows_load && self.solver.is_stable_derivative(&self.state.taut));
        let constraints = if is_stable { None } else { self.constraints(&drives(h)) };
        let step_ratio = match constraints {
            None => f64::INFINITY,
            Some(constraints) if self.has_follower_loads() => {
                self.step_ratio_of_eigenvalues(&constraints, h)
            }
            Some(constraints) => self.step_ratio_of_energy(&constraints, h, knows_load),
        };
        if step_ratio == f64::INFINITY {
            self.step_size.deviates = false;
        }
        step_ratio
    }

    /// The same where an energy decides; `knows_load`: whether the derivative is one under the
    /// present load.
    fn step_ratio_of_energy(
        &mut self,
        constraints: &[TendonConstraint],
        h: f64,
        knows_load: bool,
    ) -> f64 {
        // 1. The derivative at hand, old as it may be, often shows a wide margin.
        if knows_load && self.tangent(constraints, 0.0).exceeds(SAFE_MARGIN) {
            self.solver.mark_derivative_stable(&self.state.taut);
            return f64::INFINITY;
        }
        self.refresh_motion(constraints);
        let tangent = self.tangent(constraints, 0.0);
        if tangent.exceeds(0.0) {
            if tangent.exceeds(SAFE_MARGIN) {
                self.solver.mark_derivative_stable(&self.state.taut);
            }
            return f64::INFINITY;
        }
        // K + s·D + s²·M is positive definite where nothing grows faster than s (docs/method/rod.md).
        let rate = MAX_GROWTH_PER_STEP / h;
        if !self.tangent(constraints, rate).exceeds(0.0) {
            // Something grows by more than exp(0.5) in a step: halve it and try again.
            return 0.5;
        }
        if let Some(direction) = self.preferred_direction(&tangent.descents()) {
            // A perfectly symmetric rod would stay on the unstable branch for ever.
            self.deviate_once(&direction, rate);
        }
        // Growth slower than half the rate lets the next step be twice as long.
        if self.tangent(constraints, 0.5 * rate).exceeds(0.0) { 2.0 } else { 1.0 }
    }

    /// The same under loads without a potential.
    fn step_ratio_of_eigenvalues(&mut self, constraints: &[TendonConstraint], h: f64) -> f64 {
        if let Some(limit) =
            self.step_size.flutter.as_mut().filter(|limit| limit.remaining_steps > 0)
        {
            limit.remaining_steps -= 1;
            // Eigenvalues cost far more than a step, so a limit serves for several.
            return limit.longest_s / h;
        }
        self.step_size.flutter = None;
        self.refresh_motion(constraints);
        let (rate, max_per_step) = match self.growth(constraints) {
            Some(Growth::Divergence(rate)) => (rate, MAX_GROWTH_PER_STEP),
            Some(Growth::Flutter(rate)) => (rate, MAX_ANGLE_PER_STEP),
            Some(Growth::None) | None => {
                self.solver.mark_derivative_stable(&self.state.taut);
                return f64::INFINITY;
            }
        };
        let step_ratio = max_per_step / (rate * h);
        self.step_size.flutter =
            Some(FlutterLimit { longest_s: max_per_step / rate, remaining_steps: FLUTTER_STEPS });
        if step_ratio >= 1.0 {
            let sideways = self.sideways();
            self.deviate_once(&sideways, rate);
        }
        step_ratio
    }

    /// [`Rod::deviate`] when deviations begin to grow.
    fn deviate_once(&mut self, direction: &[f64], rate: f64) {
        if !std::mem::replace(&mut self.step_size.deviates, true) {
            self.deviate(direction, rate);
        }
    }

    /// A change of the polynomial coefficients that bends the rod to the preferred side.
    fn sideways(&self) -> Vec<f64> {
        let system = &self.system;
        let mut direction = vec![0.0; system.grid.unknowns];
        // A moment about the world's y bends the tip towards +x, the preferred side.
        let about_y = self.state.shape.end_r[0].tr_mul(&Vector3::y());
        for node in &system.grid.nodes {
            (0..3).for_each(|axis| direction[node.offset[axis]] = about_y[axis]);
        }
        direction
    }

    /// The derivative at the end of the step that has just been solved.
    fn refresh_motion(&mut self, constraints: &[TendonConstraint]) {
        let loads = self.full_loads();
        self.refresh(constraints, &loads, false);
    }
}
