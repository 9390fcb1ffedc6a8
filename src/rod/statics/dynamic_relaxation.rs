//! Equilibria that Newton's method misses: the rod is let go as if in honey and followed until it is at rest.
//!
//! An inertia-free, heavily damped rod that takes implicit Euler steps minimises its energy plus the square of the
//! distance from where it was (a proximal point method): each step lowers the energy, passes limit points by snapping,
//! and can only come to rest where the equilibrium is stable. Loads are raised together during the first steps.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::equations::motion::Motion;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rod::Rod;

/// Damping over stiffness of the honey, s: so much that inertia plays no part.
const OVERDAMPED_TIME_S: f64 = 1e4;
/// Solves and Newton iterations before giving up.
const MOST_SOLVES: usize = 120;
const MOST_ITERATIONS: u64 = 1000;
/// Iterations times cells before giving up.
const MOST_WORK: u64 = 40_000;
/// Newton iterations that a step may take before a shorter one is tried.
const MAX_ITERATIONS: usize = 25;
/// Steps in damping times: the first, the shortest, and the one after which the rod counts as being at rest.
const FIRST_STEP: f64 = 0.5;
const SHORTEST_STEP: f64 = 1e-4;
const LONGEST_STEP: f64 = 1e3;
const FALLING_STEP: f64 = 0.02;
/// Share of the loads that the first step raises.
const FIRST_SHARE: f64 = 0.1;
/// A rod that cannot be followed beyond this length of backbone, or of a tendon's path, per relaxed length is crushed.
const NEARLY_CRUSHED: f64 = 0.05;

impl Rod {
    /// Follows the overdamped rod under `holds` from where the unknowns stand, with loads that rise from `share` to
    /// their value, to a rest that Newton's method then sharpens.
    pub(crate) fn relax_dynamically(&mut self, holds: &[TendonConstraint], mut share: f64) -> SolveStatus {
        let mut overdamped = self.overdamped();
        // Long rods with many cells take longer over each iteration.
        let max_iterations = (MOST_WORK / overdamped.system.grid.cells.len().max(1) as u64).clamp(200, MOST_ITERATIONS);
        // A rod under its full load starts next to an unstable equilibrium, which longer steps would find again.
        let falling = share == 1.0;
        let (mut step, mut rise) = (if falling { FALLING_STEP } else { FIRST_STEP }, FIRST_SHARE);
        let mut status = SolveStatus::NotConverged;
        let mut last_move = if falling { 0.0 } else { f64::INFINITY };
        for _ in 0..MOST_SOLVES {
            let target = f64::min(share + rise, 1.0);
            let start = overdamped.state.clone();
            overdamped.motion.prepare(&start, &overdamped.system.masses, &[1.0], &[], step * OVERDAMPED_TIME_S);
            status = overdamped.solve_static(holds, target);
            if status != SolveStatus::Converged {
                overdamped.state = start;
                (step, rise) = (0.25 * step, 0.3 * rise);
                if step < SHORTEST_STEP || overdamped.nearly_crushed() || overdamped.solver.iterations > max_iterations
                {
                    break;
                }
                continue;
            }
            let arrived = share == 1.0 && step >= LONGEST_STEP;
            let change: Vec<f64> = overdamped.state.unknowns.iter().zip(&start.unknowns).map(|(a, b)| a - b).collect();
            let moved = overdamped
                .system
                .size_of_step_m(&change[..overdamped.system.grid.unknowns], &overdamped.solver.workspace);
            if share < 1.0 {
                step = f64::min(1.5 * step, 2.0);
            } else if moved < last_move {
                // Only a rod that slows down may take longer steps: they would take one that gathers speed back to the
                // unstable equilibrium that it leaves.
                step = f64::min(4.0 * step, LONGEST_STEP);
            } else if last_move > 0.0 && moved < 1.3 * last_move {
                step = f64::min(1.5 * step, 2.0);
            }
            last_move = moved;
            (share, rise) = (target, 1.5 * rise);
            if arrived {
                break;
            }
        }
        self.solver.iterations += overdamped.solver.iterations;
        self.solver.derivatives += overdamped.solver.derivatives;
        self.solver.factorisations += overdamped.solver.factorisations;
        if status != SolveStatus::Converged || share < 1.0 {
            return if overdamped.nearly_crushed() { SolveStatus::Crushed } else { SolveStatus::NotConverged };
        }
        self.state.unknowns.clone_from(&overdamped.state.unknowns);
        self.state.taut.clone_from(&overdamped.state.taut);
        self.motion = Motion::rest(&self.system.grid, &self.system.masses);
        self.solve_static(holds, 1.0)
    }

    fn nearly_crushed(&self) -> bool {
        self.least_stretch() < NEARLY_CRUSHED
    }

    /// The same rod in the same shape, slow.
    fn overdamped(&self) -> Rod {
        let mut params = self.system.params.clone();
        params.damping_time_s = OVERDAMPED_TIME_S;
        params.drag_n_s2_m3 = 0.0;
        let mut overdamped = Rod::new(params);
        overdamped.tip_load = self.tip_load;
        overdamped.state.unknowns.clone_from(&self.state.unknowns);
        overdamped.state.taut.clone_from(&self.state.taut);
        overdamped.state.histories.clone_from(&self.state.histories);
        let (system, state) = (&overdamped.system, &mut overdamped.state);
        state.shape.update(&system.grid, &system.sections, &state.unknowns[..system.grid.unknowns]);
        overdamped.solver.max_iterations = MAX_ITERATIONS;
        overdamped
    }
}
