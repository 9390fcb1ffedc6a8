//! From an equilibrium that the rod would leave to the one in which it ends.
//!
//! The loads are raised from those of the rest before to the present ones, as long as the rod is
//! stable under them. Where it is not any more, it is let go under the whole load and descends
//! (docs/method/robustness.md).

use crate::rod::equations::boundary_conditions::{AppliedLoads, TendonConstraint};
use crate::rod::equations::shape::distance_m;
use crate::rod::params::loads::TipWrench;
use crate::rod::solver::status::SolveStatus;
use crate::rod::stability::tangent::Tangent;
use crate::rod::state::branch::RestBranch;
use crate::rod::state::rest::SettledConditions;
use crate::rod::state::rod::Rod;
use crate::rod::state::rod_state::RodState;
use crate::rod::statics::judgement::Stability;

/// The state and the loads before a static solve; no loads: an unloaded rod, or one that has moved
/// since.
pub(crate) struct RestBefore {
    pub(crate) state: RodState,
    pub(crate) under: Option<SettledConditions>,
}

/// An equilibrium this near to the one before (share of the length) is on the same branch if it is
/// stable.
const SAME_BRANCH_LENGTHS: f64 = 0.02;
/// Under the same loads one that is firm, and this near to a firm one, is too.
const FIRM_BRANCH_LENGTHS: f64 = 0.2;
/// Places between the two equilibria at which the energy is asked for convexity, as shares of the
/// way …
const CONVEXITY_SHARES: [f64; 4] = [0.0, 0.25, 0.5, 0.75];
/// … of which one is enough if an equilibrium is firm: if the tangent there exceeds this share of
/// the elastic stiffness.
const FIRM_STIFFNESS_SHARE: f64 = 0.3;
/// Increments of the load: first, and smallest before the rod is let go.
const FIRST_INCREMENT: f64 = 0.25;
const MIN_INCREMENT: f64 = 0.004;
/// Largest motion of the tip in one increment, in lengths.
const MAX_MOVE_LENGTHS: f64 = 0.2;
/// Newton iterations of one increment.
const MAX_ITERATIONS: usize = 25;
/// Deviation of the tip, in lengths, with which the two sides of a critical equilibrium are
/// compared.
const PROBE_LENGTHS: f64 = 0.03;
/// Deviation of the tip with which a rod leaves an unstable equilibrium, in lengths.
const PUSH_LENGTHS: f64 = 0.01;
/// Elastic deflection under the imbalance, in lengths, below which both sides of an equilibrium are
/// alike.
const SAME_SHAPE_TOLERANCE: f64 = 1e-9;
/// Unstable equilibria that a rod may pass on its way.
const MAX_DESCENTS: usize = 4;
/// Energies that differ by a smaller share are equal.
const ENERGY_TOLERANCE: f64 = 1e-7;

impl Rod {
    /// Makes sure that the rod would stay in the equilibrium under `constraints` that it is in and
    /// would get there from `before`; else finds the one where it would.
    pub(crate) fn find_stable_rest(
        &mut self,
        constraints: &[TendonConstraint],
        before: &RestBefore,
    ) -> SolveStatus {
        self.branch = RestBranch::Same;
        if self.is_stable_by_bound() {
            return SolveStatus::Converged;
        }
        match self.judge(constraints) {
            Stability::Flutters => return SolveStatus::Flutters,
            Stability::Stable if self.is_on_branch_of(constraints, before) => {
                return SolveStatus::Converged;
            }
            Stability::Stable | Stability::Unstable(_) => {}
        }
        // Not proved to be the same branch: go the whole way from the rest before.
        self.state.copy_from(&before.state);
        if self.follow_loads(constraints, before) {
            self.branch = RestBranch::Same;
            self.solver.discard_derivative();
            return self.solve_static(constraints, 1.0);
        }
        self.descend(constraints)
    }

    /// Whether the present, stable equilibrium is on the branch of `before`: it is near, or the
    /// energy is convex on the straight way between them, so that no barrier lies there. Rods whose
    /// energy is not at hand are not asked.
    fn is_on_branch_of(&self, constraints: &[TendonConstraint], before: &RestBefore) -> bool {
        let length_m = self.system.params.length_m();
        let has_energy = !self.has_follower_loads() && self.system.params.moment_laws.is_empty();
        let moved = distance_m(&before.state.shape, &self.state.shape, length_m) / length_m;
        if !has_energy || moved < SAME_BRANCH_LENGTHS {
            return true;
        }
        // Tendons only stiffen: under the same loads the former shape is as stable as it was.
        let same_load = before.under.as_ref().is_some_and(|under| under.tip_load == self.tip_load);
        let firm = |tangent: &Tangent| tangent.exceeds(FIRM_STIFFNESS_SHARE);
        if same_load
            && firm(&self.tangent(constraints, 0.0))
            && (moved < FIRM_BRANCH_LENGTHS
                || firm(&self.tangent_between(constraints, before, 0.5)))
        {
            return true;
        }
        CONVEXITY_SHARES
            .into_iter()
            .all(|share| self.tangent_between(constraints, before, share).exceeds(0.0))
    }

    /// The tangent under `constraints` at a share of the straight way from `before` to the present
    /// equilibrium.
    fn tangent_between(
        &self,
        constraints: &[TendonConstraint],
        before: &RestBefore,
        share: f64,
    ) -> Tangent {
        let ends = before.state.unknowns.iter().zip(&self.state.unknowns);
        let between: Vec<f64> = ends.map(|(from, to)| from + share * (to - from)).collect();
        self.tangent_at(constraints, &between)
    }

    /// Raises the loads from those of the equilibrium `before` to the present ones as long as the
    /// rod is stable under them. False where it is not any more; then the rod is at the last stable
    /// equilibrium, and `branch` says how it loses stability.
    fn follow_loads(&mut self, constraints: &[TendonConstraint], before: &RestBefore) -> bool {
        // A rod that has moved has no equilibrium to start from.
        if before.under.is_none() && before.state.unknowns.iter().any(|&x| x != 0.0) {
            return false;
        }
        let length_m = self.system.params.length_m();
        let path = LoadPath { from: before.under.as_ref(), constraints, to: self.full_loads() };
        let max_iterations = std::mem::replace(&mut self.solver.max_iterations, MAX_ITERATIONS);
        let (mut reached, mut step) = (0.0, FIRST_INCREMENT);
        while reached < 1.0 && step >= MIN_INCREMENT {
            let target = f64::min(reached + step, 1.0);
            let saved = self.state.clone();
            self.solver.discard_derivative();
            // A long way in one increment may have jumped to another branch.
            let stable = self.solve_on_path(&path, target) == SolveStatus::Converged
                && distance_m(&saved.shape, &self.state.shape, length_m)
                    < MAX_MOVE_LENGTHS * length_m
                && self.is_stable_on_path(&path, target);
            if stable {
                (reached, step) = (target, 1.5 * step);
            } else {
                self.state = saved;
                step *= 0.4;
            }
        }
        self.solver.max_iterations = max_iterations;
        if reached < 1.0 {
            self.branch = self.loss_of_stability(&path, reached);
        }
        reached == 1.0
    }

    fn solve_on_path(&mut self, path: &LoadPath, share: f64) -> SolveStatus {
        let (constraints, loads) = path.at(share);
        self.seed_tensions(&constraints);
        self.solve_at_rest(&constraints, &loads)
    }

    fn is_stable_on_path(&mut self, path: &LoadPath, share: f64) -> bool {
        self.refresh_on_path(path, share);
        self.tangent(&path.at(share).0, 0.0).exceeds(0.0)
    }

    /// The residual and its derivative under a share of the loads.
    fn refresh_on_path(&mut self, path: &LoadPath, share: f64) {
        let (constraints, loads) = path.at(share);
        self.refresh(&constraints, &loads, true);
    }

    /// How the rod loses stability beyond `share` of the loads. At a bifurcation it softens, or
    /// stiffens, to both sides of the critical direction alike; at a limit point it softens to one
    /// side and stiffens to the other.
    fn loss_of_stability(&mut self, path: &LoadPath, share: f64) -> RestBranch {
        let constraints = path.at(share).0;
        self.refresh_on_path(path, share);
        let Some(weakest) = self.tangent(&constraints, 0.0).weakest() else {
            return RestBranch::SnapThrough;
        };
        let amount = PROBE_LENGTHS * self.system.params.length_m()
            / self.system.size_of_step_m(&weakest, &self.solver.workspace);
        let start = self.state.unknowns.clone();
        let mut stiffness = |amount: f64| {
            self.state.unknowns.clone_from(&start);
            self.push(&weakest, amount);
            self.refresh_on_path(path, share);
            self.tangent(&constraints, 0.0).along(&weakest)
        };
        let (middle, plus, minus) = (stiffness(0.0), stiffness(amount), stiffness(-amount));
        self.state.unknowns = start;
        self.solver.discard_derivative();
        // Odd part: the slope of the stiffness along the critical direction; even part: its
        // curvature.
        let (odd, even) = (0.5 * (plus - minus), 0.5 * (plus + minus) - middle);
        if odd.abs() > even.abs() { RestBranch::SnapThrough } else { RestBranch::Bifurcation }
    }

    /// Lets the rod go under the whole load, as if in honey: it descends, without crossing a
    /// barrier, to where it stays. Where both sides of an unstable equilibrium are alike it takes
    /// the one of less energy; of two equal ones that on which the tip is nearer to +x, else +y,
    /// else +z.
    fn descend(&mut self, constraints: &[TendonConstraint]) -> SolveStatus {
        for _ in 0..MAX_DESCENTS {
            self.seed_tensions(constraints);
            self.refresh_static(constraints, 1.0);
            let descents = self.tangent(constraints, 0.0).descents();
            let status =
                match self.downhill(&descents).or_else(|| self.preferred_direction(&descents)) {
                    None => self.relax_dynamically(constraints, 1.0),
                    Some(direction) => self.descend_along(constraints, &direction),
                };
            if status != SolveStatus::Converged {
                return SolveStatus::Unstable;
            }
            match self.judge(constraints) {
                Stability::Stable => return SolveStatus::Converged,
                Stability::Flutters => return SolveStatus::Flutters,
                Stability::Unstable(_) => {}
            }
        }
        SolveStatus::Unstable
    }

    /// The combination of equally unstable `directions` in which the energy falls; `None` where it
    /// falls in none.
    fn downhill(&self, directions: &[Vec<f64>]) -> Option<Vec<f64>> {
        let mut combined = vec![0.0; directions.first()?.len()];
        let mut fall = 0.0;
        for direction in directions {
            // Gradient of the energy in the subspace of the critical directions.
            let slope: f64 =
                direction.iter().zip(&self.solver.workspace.residual).map(|(d, r)| d * r).sum();
            combined.iter_mut().zip(direction).for_each(|(sum, d)| *sum -= slope * d);
            fall += slope * slope;
        }
        let size_m = self.system.size_of_step_m(&combined, &self.solver.workspace);
        (fall > 0.0 && size_m > SAME_SHAPE_TOLERANCE * self.system.params.length_m())
            .then_some(combined)
    }

    /// Descends from the present shape on the lower side of `direction`, or where the two are alike
    /// on both.
    fn descend_along(
        &mut self,
        constraints: &[TendonConstraint],
        direction: &[f64],
    ) -> SolveStatus {
        let length_m = self.system.params.length_m();
        let push =
            PUSH_LENGTHS * length_m / self.system.size_of_step_m(direction, &self.solver.workspace);
        let squares: f64 =
            direction.iter().zip(&self.system.elastic_diagonal).map(|(d, k)| k * d * d).sum();
        let uphill: f64 =
            direction.iter().zip(&self.solver.workspace.residual).map(|(d, r)| d * r).sum();
        // The deflection of the unloaded rod under the imbalance, as a share of the push.
        let deflection = uphill / (squares * push);
        if deflection.abs() * PUSH_LENGTHS > SAME_SHAPE_TOLERANCE {
            self.push(direction, -push * deflection.signum());
            return self.relax_dynamically(constraints, 1.0);
        }
        let start = self.state.clone();
        self.push(direction, push);
        // Both sides are alike, so both are followed and their energies decide.
        let first = self.relax_dynamically(constraints, 1.0);
        let (preferred, energy_j) = (self.state.clone(), self.potential_energy_j(constraints));
        self.state = start;
        self.push(direction, -push);
        let second = self.relax_dynamically(constraints, 1.0);
        let lower =
            self.potential_energy_j(constraints) < energy_j - ENERGY_TOLERANCE * energy_j.abs();
        if first == SolveStatus::Converged && (second != SolveStatus::Converged || !lower) {
            self.state = preferred;
            return first;
        }
        second
    }

    fn push(&mut self, direction: &[f64], amount: f64) {
        self.state.unknowns.iter_mut().zip(direction).for_each(|(x, d)| *x += amount * d);
    }
}

/// The way from the loads of one equilibrium to those of another.
struct LoadPath<'a> {
    from: Option<&'a SettledConditions>,
    constraints: &'a [TendonConstraint],
    to: AppliedLoads,
}

impl LoadPath<'_> {
    /// Tendon constraints and loads at `share` of the way.
    fn at(&self, share: f64) -> (Vec<TendonConstraint>, AppliedLoads) {
        let none = TipWrench::default();
        let from_load = self.from.map_or(&none, |from| &from.tip_load);
        let between = |a: f64, b: f64| a + (b - a) * share;
        let constraint = |(i, to): (usize, &TendonConstraint)| match (
            *to,
            self.from.map(|from| from.constraints[i]),
        ) {
            (TendonConstraint::Length(to), Some(TendonConstraint::Length(from))) => {
                TendonConstraint::Length(between(from, to))
            }
            (TendonConstraint::Tension(to), Some(TendonConstraint::Tension(from))) => {
                TendonConstraint::Tension(between(from, to))
            }
            (TendonConstraint::Length(to), _) => TendonConstraint::Length(share * to),
            (TendonConstraint::Tension(to), _) => TendonConstraint::Tension(share * to),
        };
        let tip = TipWrench {
            force_n: from_load.force_n.lerp(&self.to.tip.force_n, share),
            moment_nm: from_load.moment_nm.lerp(&self.to.tip.moment_nm, share),
        };
        let constraints = self.constraints.iter().enumerate().map(constraint).collect();
        // An earlier rest was under all constant loads and the whole weight; an unloaded rod was
        // under none.
        let share = if self.from.is_some() { 1.0 } else { share };
        (constraints, AppliedLoads { tip, share, gravity_m_s2: self.to.gravity_m_s2 * share })
    }
}
