//! How far a correction may go beside obstacles. A penetrated obstacle pushes back in proportion,
//! so that a whole correction could end deep inside of one, or behind it.

use nalgebra::DVector;

use super::newton_state::NewtonSolver;
use crate::rod::equations::boundary_conditions::SolveConditions;
use crate::rod::equations::shape::Shape;
use crate::rod::equations::system::RodEquations;

/// Largest force of an obstacle on one point during the iteration, in units of E·I/L²: it bends the
/// rod by ten lengths.
const MAX_CONTACT_FORCE: f64 = 10.0;
/// Attempts to find the share of a correction that respects it; the bisections among them bracket
/// it to 1/4096.
const MAX_ATTEMPTS: usize = 24;
/// Parts of a correction, each no longer than the thinnest obstacle, in which obstacles are looked
/// for.
const MAX_PARTS: f64 = 64.0;

/// A share of a correction, and the largest force of an obstacle on one point there, newtons.
#[derive(Clone, Copy)]
struct Probe {
    share: f64,
    force_n: f64,
}

/// The rod along one correction.
struct ContactSearch<'a> {
    system: &'a RodEquations,
    conditions: &'a SolveConditions<'a>,
    unknowns: &'a [f64],
    correction: &'a DVector<f64>,
    shape: Shape,
}

impl ContactSearch<'_> {
    /// Moves the shape to `share` of the correction and measures the force there.
    fn probe(&mut self, share: f64) -> Probe {
        let coefficients = &self.unknowns[..self.system.grid.unknowns];
        let moved: Vec<f64> =
            coefficients.iter().zip(self.correction.iter()).map(|(x, dx)| x - share * dx).collect();
        self.shape.update(&self.system.grid, &self.system.sections, &moved);
        Probe { share, force_n: self.system.hardest_contact_n(self.conditions, &self.shape) }
    }

    /// A share between `free`, where the force is below the limit, and `pressed`, where it is
    /// above: one with a force below the limit and not zero, so that the next derivative knows the
    /// obstacle.
    fn touch(&mut self, mut free: Probe, mut pressed: Probe, limit_n: f64) -> f64 {
        for attempt in 0..MAX_ATTEMPTS {
            // Regula falsi for half the limit, with bisections, since the force may rise steeply.
            let secant = (0.5 * limit_n - free.force_n) / (pressed.force_n - free.force_n);
            // A secant point at an end of the bracket would not shrink it.
            let part = if attempt % 2 == 0 { secant.clamp(0.05, 0.95) } else { 0.5 };
            let between = self.probe(free.share + part * (pressed.share - free.share));
            if between.force_n > limit_n {
                pressed = between;
            } else if between.force_n > 0.0 {
                return between.share;
            } else {
                free = between;
            }
        }
        free.share
    }
}

impl NewtonSolver {
    /// The share of a correction up to which no obstacle presses harder than [`MAX_CONTACT_FORCE`]
    /// or than now. Beyond, the derivative belongs to another shape.
    pub(super) fn share_up_to_contact(
        &self,
        system: &RodEquations,
        unknowns: &[f64],
        correction: &DVector<f64>,
        conditions: &SolveConditions,
    ) -> f64 {
        if system.contact_points.is_empty() {
            return 1.0;
        }
        let shape = &self.workspace.shape;
        // A rod that presses harder already must still be allowed to move.
        let current = Probe { share: 0.0, force_n: system.hardest_contact_n(conditions, shape) };
        let limit_n = current.force_n.max(MAX_CONTACT_FORCE * system.bending_force_n());
        let mut search =
            ContactSearch { system, conditions, unknowns, correction, shape: shape.clone() };
        let full_step = search.probe(1.0);
        // A thin obstacle must not be jumped over.
        let moved_m = system.contact_motion_m(shape, &search.shape);
        let parts = (moved_m / system.thinnest_obstacle_m()).ceil().clamp(1.0, MAX_PARTS) as usize;
        let mut free = current;
        for part in 1..=parts {
            let next =
                if part == parts { full_step } else { search.probe(part as f64 / parts as f64) };
            if next.force_n > limit_n {
                return search.touch(free, next, limit_n);
            }
            if next.force_n > 0.0 && current.force_n <= 0.0 {
                // At first contact the next derivative must learn of the obstacle.
                return next.share;
            }
            free = next;
        }
        1.0
    }
}
