//! Dynamic relaxation, for equilibria that the Newton iteration does not reach: an overdamped rod
//! is followed to rest.
//!
//! Implicit Euler steps of an inertia-free, heavily damped rod minimise its energy plus the squared
//! distance from the previous shape (a proximal point method). Each step lowers the energy, passes
//! limit points by snapping through, and can only come to rest at a stable equilibrium. All loads
//! are raised together during the first steps. docs/method/robustness.md says when it is used.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::equations::motion::Motion;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// Damping over stiffness of the overdamped rod, s: large enough that inertia is negligible.
const OVERDAMPED_TIME_S: f64 = 1e4;
/// Limits on solves and Newton iterations.
const MAX_SOLVES: usize = 120;
const MAX_ITERATIONS: u64 = 1000;
/// Limit on iterations times cells.
const MAX_WORK: u64 = 40_000;
/// Newton iterations per step before a shorter one is tried.
const MAX_NEWTON_ITERATIONS: usize = 25;
/// Steps in damping times: first, shortest, longest (after which the rod counts as at rest), and
/// first under full load.
const FIRST_STEP: f64 = 0.5;
const MIN_STEP: f64 = 1e-4;
const MAX_STEP: f64 = 1e3;
const FALLING_STEP: f64 = 0.02;
/// Factor on these limits for a rod that falls: next to a bifurcation it gathers speed slowly, and
/// it rests only once it has turned about the axis of its load.
const FALLING_EFFORT: usize = 3;
/// Motion in one longest step below which the rod is at rest, in lengths.
const REST_MOTION_LENGTHS: f64 = 1e-4;
/// Share of the loads that the first step raises.
const FIRST_INCREMENT: f64 = 0.1;
/// A rod that fails below this length of backbone, or of tendon path, per relaxed length is
/// reported as crushed.
const CRUSHED_TOLERANCE: f64 = 0.05;

impl Rod {
    /// Follows the overdamped rod under `constraints` from the present unknowns to rest while the
    /// loads rise from `share` to their full value. A Newton solve then refines the result.
    pub(crate) fn relax_dynamically(
        &mut self,
        constraints: &[TendonConstraint],
        mut share: f64,
    ) -> SolveStatus {
        let mut overdamped = self.overdamped();
        // Long rods with many cells take longer over each iteration.
        let max_iterations = (MAX_WORK / overdamped.system.grid.cell_lengths_m.len().max(1) as u64)
            .clamp(200, MAX_ITERATIONS);
        // A rod under its full load starts next to an unstable equilibrium, which longer steps
        // would find again.
        let falling = share == 1.0;
        let effort = if falling { FALLING_EFFORT } else { 1 };
        let (mut step, mut increment) =
            (if falling { FALLING_STEP } else { FIRST_STEP }, FIRST_INCREMENT);
        let mut status = SolveStatus::NotConverged;
        let mut last_move = if falling { 0.0 } else { f64::INFINITY };
        for _ in 0..effort * MAX_SOLVES {
            let target = f64::min(share + increment, 1.0);
            let start = overdamped.state.clone();
            // One stage with γ = 1 is implicit Euler.
            overdamped.motion.prepare(
                &start,
                &overdamped.system.masses,
                &[1.0],
                &[],
                step * OVERDAMPED_TIME_S,
            );
            status = overdamped.solve_static(constraints, target);
            if status != SolveStatus::Converged || !overdamped.has_descended(constraints, target) {
                // A converged step that has not descended has led to another branch.
                status = status.or(SolveStatus::NotConverged);
                overdamped.state = start;
                (step, increment) = (0.25 * step, 0.3 * increment);
                if step < MIN_STEP
                    || overdamped.nearly_crushed()
                    || overdamped.solver.iterations > effort as u64 * max_iterations
                {
                    break;
                }
                continue;
            }
            let change: Vec<f64> =
                overdamped.state.unknowns.iter().zip(&start.unknowns).map(|(a, b)| a - b).collect();
            let moved = overdamped.system.size_of_step_m(
                &change[..overdamped.system.grid.unknowns],
                &overdamped.solver.workspace,
            );
            let arrived = share == 1.0
                && step >= MAX_STEP
                && moved < REST_MOTION_LENGTHS * overdamped.system.params.length_m();
            if share < 1.0 {
                // While the loads rise the rod must keep up with them.
                step = f64::min(1.5 * step, 2.0);
            } else {
                // One that slows down may take longer steps.
                step = f64::min(if moved < last_move { 4.0 } else { 1.5 } * step, MAX_STEP);
            }
            last_move = moved;
            (share, increment) = (target, 1.5 * increment);
            if arrived {
                break;
            }
        }
        self.solver.iterations += overdamped.solver.iterations;
        self.solver.derivatives += overdamped.solver.derivatives;
        self.solver.factorisations += overdamped.solver.factorisations;
        if status != SolveStatus::Converged || share < 1.0 {
            return if overdamped.nearly_crushed() {
                SolveStatus::Crushed
            } else {
                SolveStatus::NotConverged
            };
        }
        self.state.unknowns.clone_from(&overdamped.state.unknowns);
        self.state.taut.clone_from(&overdamped.state.taut);
        // The result is refined without damping.
        self.motion = Motion::rest(&self.system.grid, &self.system.masses);
        self.solve_static(constraints, 1.0)
    }

    /// Whether the step just taken has lowered energy plus distance: where the tangent of the step
    /// is not positive definite, the step has led to an unstable equilibrium, or past one.
    fn has_descended(&mut self, constraints: &[TendonConstraint], share: f64) -> bool {
        if self.has_follower_loads() || self.is_below_buckling() {
            return true;
        }
        self.refresh_static(constraints, share);
        self.tangent(constraints, self.motion.rate).exceeds(0.0)
    }

    fn nearly_crushed(&self) -> bool {
        self.min_stretch() < CRUSHED_TOLERANCE
    }

    /// The same rod in the same shape, overdamped.
    fn overdamped(&self) -> Rod {
        let mut params = self.system.params.clone();
        params.damping_time_s = OVERDAMPED_TIME_S;
        // Quadratic drag would only slow the way to the same rest.
        params.drag_n_s2_m3 = 0.0;
        let mut overdamped = Rod::new(params);
        overdamped.tip_load = self.tip_load;
        overdamped.state.unknowns.clone_from(&self.state.unknowns);
        overdamped.state.taut.clone_from(&self.state.taut);
        overdamped.state.histories.clone_from(&self.state.histories);
        overdamped.state.sliding.clone_from(&self.state.sliding);
        overdamped.state.contact_memory.clone_from(&self.state.contact_memory);
        let (system, state) = (&overdamped.system, &mut overdamped.state);
        state.shape.update(&system.grid, &system.sections, &state.unknowns[..system.grid.unknowns]);
        overdamped.solver.max_iterations = MAX_NEWTON_ITERATIONS;
        overdamped
    }
}
