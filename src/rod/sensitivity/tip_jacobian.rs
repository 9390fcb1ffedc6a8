//! Derivatives of the tip and of other places of a rod at rest with respect to commands and loads
//! (`docs/method/sensitivities.md`).
//!
//! At rest F(x; c) = 0 for the unknowns x under the commands c, so dx/dc = −(∂F/∂x)⁻¹ ∂F/∂c. The
//! derivative is taken at the solution, for the tendons that are taut there.

use nalgebra::{DVector, Dyn, LU, Matrix3, Vector3};

use crate::math::rotation;
use crate::rod::equations::boundary_conditions::{SolveConditions, TendonConstraint};
use crate::rod::equations::jacobian::Derivative;
use crate::rod::equations::motion::Motion;
use crate::rod::equations::system::Workspace;
use crate::rod::params::tendon::Tendon;
use crate::rod::state::rod::Rod;

/// The variable of a tip derivative. Tendons and axes count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Displacement of a tendon's drive, per metre; zero where the tendon is slack or not
    /// length-controlled.
    Pull(usize),
    /// Prescribed tension of a tendon (zero for a following one), per newton; zero where the
    /// tension is not prescribed.
    Tension(usize),
    /// Force on the tip along an axis of the world, per newton.
    Force(usize),
    /// Moment on the tip about an axis of the world, per newton metre.
    Moment(usize),
}

/// Derivative of the pose of the tip or of another tracked point, per unit of the variable, world
/// frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipRate {
    /// Of the position, metres.
    pub position_m: Vector3<f64>,
    /// Of the orientation: the rotation vector of a small change, radians.
    pub rotation_rad: Vector3<f64>,
}

/// Derivatives with respect to one variable, per unit of it.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseRates {
    /// Of the tip.
    pub tip: TipRate,
    /// Of further places on the rod or points on its body, in the order in which they were asked
    /// for.
    pub points: Vec<TipRate>,
}

impl PoseRates {
    /// Sets all of them to zero.
    pub fn clear(&mut self) {
        self.tip = TipRate::ZERO;
        self.points.fill(TipRate::ZERO);
    }
}

impl TipRate {
    const ZERO: TipRate = TipRate {
        position_m: Vector3::new(0.0, 0.0, 0.0),
        rotation_rad: Vector3::new(0.0, 0.0, 0.0),
    };
}

/// Step of the central difference that refines a derivative, in lengths of the rod.
const PROBE_LENGTHS: f64 = 1e-5;
/// Step of the central difference with respect to a command to a tendon with friction: a share of
/// its presliding, and newtons.
const PRESLIDING_SHARE: f64 = 1e-3;
const TENSION_STEP_N: f64 = 1e-5;
/// Refinements with tendons that have friction, whose mobilised share J holds fixed, and what may
/// remain of the derivative.
const MAX_REFINEMENTS: usize = 40;
const REFINEMENT_TOLERANCE: f64 = 1e-7;

/// The equations and the poses at unknowns beside a solution.
struct ShiftedSolution {
    residual: DVector<f64>,
    tip: SectionPose,
    points: Vec<SectionPose>,
}

/// Position (metres) and orientation.
type SectionPose = (Vector3<f64>, Matrix3<f64>);

/// The equations at a solution.
struct Linearised<'a> {
    conditions: &'a SolveConditions<'a>,
    derivative: &'a Derivative,
    factors: &'a LU<f64, Dyn, Dyn>,
}

impl Rod {
    /// Derivative of the tip with respect to each of `directions`, at the pose in which
    /// [`Rod::settle`] left the rod. `None` when the rod is not at rest, has moved since, or the
    /// tangent is singular.
    pub fn tip_jacobian(&mut self, directions: &[Direction]) -> Option<Vec<TipRate>> {
        let rates = self.pose_jacobian(directions, &[])?;
        Some(rates.into_iter().map(|rates| rates.tip).collect())
    }

    /// [`Rod::tip_jacobian`] with the derivatives of the cross-sections at these arc lengths,
    /// metres from the base along the unloaded rod.
    pub fn pose_jacobian(
        &mut self,
        directions: &[Direction],
        places_m: &[f64],
    ) -> Option<Vec<PoseRates>> {
        let rest = self.settled_under.as_ref()?;
        let motion = Motion::rest(&self.system.grid, &self.system.masses);
        let loads = self.full_loads();
        // Histories, sliding and contacts as they were before the rest was committed.
        let conditions = SolveConditions {
            histories: &rest.histories,
            sliding: &rest.sliding,
            contact_memory: &rest.contact_memory,
            rested_s: rest.rested_s,
            ..self.state.conditions(&motion, &rest.constraints, &loads, true)
        };
        let mut workspace = self.solver.workspace.clone();
        let mut derivative = Derivative::new(&self.system);
        self.system.evaluate(&self.state.unknowns, &conditions, &mut workspace);
        derivative.update(&self.system, &self.state.unknowns, &conditions, &workspace);
        let factors = derivative.matrix(&self.system, &conditions).lu();
        let mut shifted = workspace.clone();
        let rate = |&direction: &Direction| {
            let explicit = self.residual_rate(direction, &conditions, &workspace);
            let solution =
                Linearised { conditions: &conditions, derivative: &derivative, factors: &factors };
            self.pose_rates(&explicit, &solution, places_m, &mut shifted)
        };
        directions.iter().map(rate).collect()
    }

    /// Derivatives where ∂F/∂direction is `explicit`: dx = −J⁻¹ ∂F/∂direction, refined once by a
    /// central difference of F along dx, since J neglects the coupling of strain rates within a
    /// cell.
    fn pose_rates(
        &self,
        explicit: &DVector<f64>,
        solution: &Linearised,
        places_m: &[f64],
        shifted: &mut Workspace,
    ) -> Option<PoseRates> {
        let &Linearised { conditions, derivative, factors } = solution;
        let n = self.system.grid.unknowns;
        let mut change = -explicit;
        if !factors.solve_mut(&mut change) {
            return None;
        }
        let size_m = self.system.size_of_step_m(&change.as_slice()[..n], shifted);
        if size_m == 0.0 {
            return Some(PoseRates {
                tip: TipRate::ZERO,
                points: vec![TipRate::ZERO; places_m.len()],
            });
        }
        let share = PROBE_LENGTHS * self.system.params.length_m() / size_m;
        if self.system.params.tendons.iter().any(Tendon::has_friction) {
            self.refine(&mut change, explicit, solution, shifted)?;
        }
        let mut at = |along: &DVector<f64>, sign: f64| {
            self.evaluate_shifted(along, sign * share, conditions, shifted);
            let shape = &shifted.shape;
            ShiftedSolution {
                residual: DVector::from_column_slice(&shifted.residual),
                tip: (shape.tip_m(), shape.tip_rotation()),
                points: places_m
                    .iter()
                    .map(|&place_m| shape.pose_at(&self.system.grid, place_m))
                    .collect(),
            }
        };
        let between =
            |(after_m, after_r): SectionPose, (before_m, before_r): SectionPose| TipRate {
                position_m: (after_m - before_m) / (2.0 * share),
                rotation_rad: rotation::log(&(after_r * before_r.transpose())) / (2.0 * share),
            };
        let (after, before) = (at(&change, 1.0), at(&change, -1.0));
        // What J has missed of F along dx is one more right-hand side.
        let mut remainder = -(explicit + (after.residual - before.residual) / (2.0 * share));
        if !factors.solve_mut(&mut remainder) {
            return None;
        }
        let last = derivative.variation.end_move.len() - 1;
        let correction = &remainder.as_slice()[..n];
        let mut tip = between(after.tip, before.tip);
        // The remainder is small, so its motion by the linear variation is exact enough.
        tip.position_m += derivative.variation.end_move[last].times(correction);
        tip.rotation_rad += derivative.variation.end_turn[last].times(correction);
        let points = if places_m.is_empty() {
            Vec::new()
        } else {
            // Places between cell ends have no stored variation, so the difference is taken again.
            let refined = &change + &remainder;
            let (after, before) = (at(&refined, 1.0), at(&refined, -1.0));
            after
                .points
                .into_iter()
                .zip(before.points)
                .map(|(after, before)| between(after, before))
                .collect()
        };
        Some(PoseRates { tip, points })
    }

    /// Evaluates the equations at the present unknowns plus `share` of a change.
    fn evaluate_shifted(
        &self,
        change: &DVector<f64>,
        share: f64,
        conditions: &SolveConditions,
        shifted: &mut Workspace,
    ) {
        let shift = self.state.unknowns.iter().zip(change.iter());
        let unknowns: Vec<f64> = shift.map(|(x, dx)| x + share * dx).collect();
        self.system.evaluate(&unknowns, conditions, shifted);
    }

    /// Refines `change` until dF along it and `explicit` cancel; `None` when that does not
    /// converge.
    fn refine(
        &self,
        change: &mut DVector<f64>,
        explicit: &DVector<f64>,
        solution: &Linearised,
        shifted: &mut Workspace,
    ) -> Option<()> {
        let n = self.system.grid.unknowns;
        for _ in 0..MAX_REFINEMENTS {
            let size_m = self.system.size_of_step_m(&change.as_slice()[..n], shifted);
            let share = PROBE_LENGTHS * self.system.params.length_m() / size_m;
            let mut residual = |sign: f64| {
                self.evaluate_shifted(change, sign * share, solution.conditions, shifted);
                DVector::from_column_slice(&shifted.residual)
            };
            // Iterative refinement: central differences along `change` show what the factors, an
            // approximation, have not cancelled.
            let mut remainder = -(explicit + (residual(1.0) - residual(-1.0)) / (2.0 * share));
            if !solution.factors.solve_mut(&mut remainder) {
                return None;
            }
            *change += &remainder;
            if self.system.size_of_step_m(&remainder.as_slice()[..n], shifted)
                <= REFINEMENT_TOLERANCE * size_m
            {
                return Some(());
            }
        }
        None
    }

    /// Writes ∂F/∂direction for the command to tendon `i`, which has friction, into `rate`: zero
    /// for a tendon that is slack or held otherwise.
    fn rate_of_command(
        &self,
        direction: Direction,
        i: usize,
        conditions: &SolveConditions,
        rate: &mut DVector<f64>,
    ) {
        let tendon = &self.system.params.tendons[i];
        let step = match (direction, conditions.constraints[i]) {
            (Direction::Pull(_), TendonConstraint::Length(_)) if conditions.taut[i] => {
                PRESLIDING_SHARE * tendon.presliding_m
            }
            (Direction::Tension(_), TendonConstraint::Tension(_)) => TENSION_STEP_N,
            _ => return,
        };
        let mut workspace = self.solver.workspace.clone();
        let mut residual = |change: f64| {
            let mut constraints = conditions.constraints.to_vec();
            constraints[i] = match constraints[i] {
                TendonConstraint::Length(pull_m) => TendonConstraint::Length(pull_m + change),
                TendonConstraint::Tension(tension_n) => {
                    TendonConstraint::Tension(tension_n + change)
                }
            };
            let shifted = SolveConditions { constraints: &constraints, ..*conditions };
            self.system.evaluate(&self.state.unknowns, &shifted, &mut workspace);
            DVector::from_column_slice(&workspace.residual)
        };
        *rate = (residual(step) - residual(-step)) / (2.0 * step);
    }

    /// ∂F/∂direction at fixed unknowns.
    fn residual_rate(
        &self,
        direction: Direction,
        conditions: &SolveConditions,
        workspace: &Workspace,
    ) -> DVector<f64> {
        let n = self.system.grid.unknowns;
        let mut rate = DVector::zeros(self.system.size());
        match direction {
            Direction::Pull(i) | Direction::Tension(i)
                if self.system.params.tendons.get(i).is_some_and(Tendon::has_friction) =>
            {
                self.rate_of_command(direction, i, conditions, &mut rate);
            }
            Direction::Pull(i) => {
                if matches!(conditions.constraints.get(i), Some(TendonConstraint::Length(_)))
                    && conditions.taut[i]
                {
                    let tendon = &self.system.params.tendons[i];
                    rate[n + i] =
                        // A pulled tendon is longer, and its compliance grows in proportion.
                        1.0 + tendon.compliance_m_per_n / tendon.elastic_length_m * self.state.unknowns[n + i];
                }
            }
            Direction::Tension(i) => {
                if matches!(conditions.constraints.get(i), Some(TendonConstraint::Tension(_))) {
                    rate[n + i] = -1.0;
                }
            }
            Direction::Force(axis) => {
                self.add_load(unit(axis), Vector3::zeros(), workspace, &mut rate)
            }
            Direction::Moment(axis) => {
                self.add_load(Vector3::zeros(), unit(axis), workspace, &mut rate)
            }
        }
        rate
    }

    /// Adds the effect of a tip force and moment to the balance equations.
    fn add_load(
        &self,
        force_n: Vector3<f64>,
        moment_nm: Vector3<f64>,
        workspace: &Workspace,
        rate: &mut DVector<f64>,
    ) {
        let shape = &workspace.shape;
        let tip = shape.tip_m();
        for g in 0..self.system.grid.nodes.len() {
            let back: Matrix3<f64> = shape.node_r[g].transpose();
            let moment = back * (moment_nm + (tip - shape.node_p[g]).cross(&force_n));
            let force = back * force_n;
            let wrench = [-moment.x, -moment.y, -moment.z, -force.x, -force.y, -force.z];
            self.system.project(
                g,
                &workspace.shape.compliance[g].apply(&wrench),
                rate.as_mut_slice(),
            );
        }
    }
}

fn unit(axis: usize) -> Vector3<f64> {
    Vector3::from_fn(|row, _| f64::from(u8::from(row == axis)))
}
