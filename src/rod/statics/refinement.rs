//! Is the grid fine enough? Static solves that refine cells and polynomials until the estimate of what the
//! discretisation in space puts the tip off by is small enough (docs/robustness.md).

use std::sync::{Arc, OnceLock};

use super::reconstruction::Confirmed;
use crate::rod::discretisation::grid::element_ends;
use crate::rod::equations::boundary_conditions::Hold;
use crate::rod::equations::material::Section;
use crate::rod::equations::shape::Shape;
use crate::rod::equations::system::System;
use crate::rod::params::rod_params::{Resolution, RodParams};
use crate::rod::state::rod::Rod;
use crate::rod::solver::status::Status;

/// How often the grid may be refined: cells to a sixteenth, and polynomials that end at every jump of the material.
const MOST_REFINEMENTS: u32 = 4;
/// Polynomials added by the first refinement; each further one adds two more than the one before.
const MORE_MODES: usize = 4;
/// About as many polynomial coefficients may the levels from the second on have.
const MOST_UNKNOWNS: [usize; MOST_REFINEMENTS as usize - 1] = [250, 400, 600];
/// Newton iterations from one grid to the next.
const PATIENCE: usize = 40;
/// Shapes on two grids that lie further apart than this share of the length may be two equilibria.
const ANOTHER: f64 = 1e-3;
/// Refinement stops at cells of this share of the length.
const MOST_CELLS: f64 = 300.0;
/// A rod whose material remembers has fronts where it yields, kinks that no polynomial resolves: such rods are held to
/// this many times the tolerance.
const MEMORY_TOLERANCE: f64 = 100.0;
/// Share of the length that the estimate may say a moving rod's tip is off by before its answer is refused.
const MOTION_BOUND: f64 = 0.05;
/// What a rod knows of its discretisation.
#[derive(Clone, Debug)]
pub(crate) struct Space {
    /// Resolution that was asked for.
    pub(crate) base: Resolution,
    /// How often it has been refined.
    pub(crate) level: u32,
    /// What the grid may put the tip off by, metres.
    pub(crate) error_m: f64,
    /// Largest compliance against turning anywhere, 1/(N m²).
    pub(crate) softest: f64,
    /// The same polynomials on twice as many cells, once they have been asked for.
    halved: Arc<OnceLock<System>>,
    /// The last shape that was reconstructed.
    pub(crate) confirmed: Option<Confirmed>,
}

impl Space {
    pub(crate) fn new(system: &System) -> Space {
        let softest = system.sections.iter().map(Section::softest_turn).fold(0.0, f64::max);
        Space {
            base: system.params.resolution,
            level: 0,
            error_m: 0.0,
            softest,
            halved: Arc::default(),
            confirmed: None,
        }
    }

    /// `system` with the same polynomials on twice as many cells.
    pub(crate) fn halved(&self, system: &System) -> &System {
        self.halved.get_or_init(|| System::on(system.grid.halved(&system.params.resolution), system.params.clone()))
    }

    /// A rod that starts anew does not know its earlier shapes.
    pub(crate) fn forget(&mut self) {
        self.confirmed = None;
    }
}

impl RodParams {
    /// The same rod with `base` refined `level` times: cells are halved and polynomials added each time. From the second
    /// time on polynomials end at every jump of the material; many elements get fewer polynomials each.
    pub(crate) fn refined(&self, base: &Resolution, level: u32) -> RodParams {
        let mut params = RodParams { resolution: *base, ..self.clone() };
        if level == 0 {
            return params;
        }
        let k = level as usize - 1;
        let more: usize = (0..=k).map(|k| MORE_MODES + 2 * k).sum();
        let (mut bending, mut others) = (usize::MAX, usize::MAX);
        if level > 1 {
            params.resolution.split_elements = true;
            let own = MOST_UNKNOWNS[k - 1] / (element_ends(&params).len() - 1);
            // Half as many again for two bending moments as for each of the four other components.
            others = (own / 7).max(1 + k);
            bending = others + others / 2;
        }
        params.resolution = Resolution {
            cell_m: (base.cell_m / f64::from(1 << level)).max(self.length_m() / MOST_CELLS).min(base.cell_m),
            bending_modes: bending.min(base.bending_modes + more),
            torsion_modes: others.min(base.torsion_modes + more),
            shear_modes: others.min(base.shear_modes + more),
            axial_modes: others.min(base.axial_modes + more),
            ..params.resolution
        };
        params
    }
}

impl Rod {
    /// What the discretisation in space may put the tip off by, metres: after a static solve the larger one of an estimate
    /// and of what a reconstruction says; in motion an estimate.
    pub fn space_error_m(&self) -> f64 {
        self.space.error_m
    }

    /// How often the grid has been refined beyond the resolution that was asked for.
    pub fn refinements(&self) -> u32 {
        self.space.level
    }

    /// Judges a shape at rest that solves the equations under `holds`: is it possible, does a finer grid agree?
    /// Refines until the grid is fine enough; a rod whose shape is refused goes back to the grid that it had.
    pub(crate) fn examine_rest(&mut self, holds: &[Hold]) -> Status {
        let status = self.leave_if_unstable(holds);
        if status != Status::Converged {
            return status;
        }
        let share = if self.system.params.memory.is_empty() { 1.0 } else { MEMORY_TOLERANCE };
        let tolerance_m = share * self.space.base.static_tolerance_m;
        let mut estimate = self.estimate();
        if estimate.cautious_m() > tolerance_m && self.solve_static(holds, 1.0) == Status::Converged {
            // The last iteration left an imbalance of its own; one more does not.
            estimate = self.estimate();
        }
        self.space.error_m = estimate.cautious_m();
        self.confirm(holds, tolerance_m, estimate.plain_m());
        if self.space.error_m <= tolerance_m {
            return self.possible();
        }
        let mut fallback = None;
        let mut status = Status::UnderResolved;
        while self.space.error_m > tolerance_m && self.space.level < MOST_REFINEMENTS {
            let mut finer = self.on_grid(self.space.level + 1);
            let patience = std::mem::replace(&mut finer.solver.patience, PATIENCE);
            status = finer.solve_static(holds, 1.0);
            finer.solver.patience = patience;
            // Of what polynomials that end at every jump leave, the reconstruction misses nothing.
            let estimate = finer.estimate();
            finer.space.error_m = if finer.space.level > 1 { 0.0 } else { estimate.cautious_m() };
            finer.confirm(holds, tolerance_m, estimate.plain_m());
            let hopeless = finer.space.level > 1 && finer.space.error_m > self.system.params.length_m();
            let coarser = std::mem::replace(self, finer);
            fallback.get_or_insert(coarser);
            if status != Status::Converged || hopeless {
                // The coarse answer stands unconfirmed.
                status = Status::UnderResolved;
                break;
            }
        }
        if status == Status::Converged {
            let settled = self.space.error_m <= tolerance_m;
            status = if settled { self.still_stable(holds, fallback.as_ref()) } else { Status::UnderResolved };
        }
        if let (true, Some(mut coarse)) = (status != Status::Converged, fallback) {
            coarse.space.error_m = self.space.error_m;
            *self = coarse;
        }
        status
    }

    /// A finer grid may have led to another equilibrium than that of `coarse`, which was a stable one.
    fn still_stable(&mut self, holds: &[Hold], coarse: Option<&Rod>) -> Status {
        let length_m = self.system.params.length_m();
        let elsewhere = coarse
            .is_some_and(|coarse| distance_m(&coarse.state.shape, &self.state.shape, length_m) > ANOTHER * length_m);
        if elsewhere && !self.certainly_stable() && self.unstable_direction(holds).is_some() {
            return Status::Unstable;
        }
        self.possible()
    }

    /// Judges the shape of a moving rod, whose grid stays as it is. What is missing in the balance meets the viscous
    /// stiffness as well.
    pub(crate) fn examine_motion(&mut self) -> Status {
        let stiffer = 1.0 + self.motion.rate * self.system.params.damping_time_s;
        let estimate = self.estimate();
        let error_m = estimate.cells_m + estimate.balance_m / stiffer;
        self.space.error_m = if error_m.is_finite() { error_m } else { f64::INFINITY };
        if self.space.error_m > MOTION_BOUND * self.system.params.length_m() {
            return Status::UnderResolved;
        }
        self.possible()
    }

    /// Whether the material keeps its order: no cross-section passes through the next, on the axis or at a tendon.
    fn possible(&self) -> Status {
        if self.least_stretch() > 0.0 { Status::Converged } else { Status::Crushed }
    }

    /// Least length of the backbone, or of the axial part of a tendon's path, per relaxed length.
    pub(crate) fn least_stretch(&self) -> f64 {
        let count = self.system.params.tendons.len();
        let mut least = f64::INFINITY;
        for (g, strain) in self.state.shape.strain.iter().enumerate() {
            least = least.min(strain[5]);
            for guide in &self.system.guides[g * count..(g + 1) * count] {
                let [x, y] = guide.offset_m;
                if guide.present {
                    least = least.min(strain[5] + strain[0] * y - strain[1] * x);
                }
            }
        }
        least
    }

    /// Goes back to the resolution that was asked for; histories along the rod are taken along.
    pub(crate) fn coarsen(&mut self) {
        if self.space.level > 0 {
            *self = self.on_grid(0);
        }
    }

    /// The same rod in the same state on the grid of another level, at rest.
    pub(crate) fn on_grid(&self, level: u32) -> Rod {
        self.carried(Rod::new(self.system.params.refined(&self.space.base, level)), level)
    }

    /// `rod`, on the grid of another level, in the state of this one.
    pub(crate) fn carried(&self, mut rod: Rod, level: u32) -> Rod {
        rod.trace.clone_from(&self.trace);
        rod.space.level = level;
        rod.space.error_m = self.space.error_m;
        rod.space.base = self.space.base;
        rod.tip_load = self.tip_load;
        let (from, to) = (&self.system.grid, &rod.system.grid);
        to.transfer(from, &self.state.unknowns, &mut rod.state.unknowns);
        rod.state.taut.clone_from(&self.state.taut);
        rod.state.memory = self.state.memory.iter().map(|states| to.spread(from, states)).collect();
        rod.state.shape.update(to, &rod.system.sections, &rod.state.unknowns[..to.unknowns]);
        rod.solver.iterations = self.solver.iterations;
        rod.solver.derivatives = self.solver.derivatives;
        rod.solver.factorisations = self.solver.factorisations;
        rod
    }
}

/// How far the tips of two shapes lie apart, metres; a turn counts as what it moves at the length of the rod.
pub(crate) fn distance_m(a: &Shape, b: &Shape, length_m: f64) -> f64 {
    let moved = (a.tip_m() - b.tip_m()).norm();
    let turned = (a.tip_rotation() - b.tip_rotation()).norm() * length_m;
    // A comparison with what is not a number must not pass for agreement.
    if moved.is_finite() && turned.is_finite() { moved.max(turned) } else { f64::INFINITY }
}
