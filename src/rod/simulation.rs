//! A rod that can be settled and moved: the interface of this room.

use nalgebra::{Matrix3, Vector3};

use super::advance::Pace;
use super::conditions::{Conditions, Hold};
use super::grid::Grid;
use super::memory::MemoryState;
use super::motion::Motion;
use super::params::{RodParams, TipLoad};
use super::refine::Space;
use super::scheme::{Scheme, Tableau};
use super::solver::Solver;
use super::state::{CrossSection, Rates, State};
use super::status::Status;
use super::system::System;
use crate::math::vectorised;

/// What a tendon is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Displacement at the drive in metres, 0 at home, positive pulls; the tendon never pushes.
    Pull(f64),
    /// Tension in newtons, ≥ 0.
    Tension(f64),
    /// No tension and no slack: the drive follows the shape.
    Follow,
}

/// Energy of the rod, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Of motion.
    pub kinetic_j: f64,
    /// Of bending, twist, shear and stretch, the compressible spine included.
    pub elastic_j: f64,
    /// Of weight, zero at the base.
    pub gravitational_j: f64,
}

/// What solving has taken so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Time steps, those that had to be repeated not counted.
    pub steps: u64,
    /// Evaluations of the equations, one an iteration.
    pub iterations: u64,
    /// Evaluations of their derivative.
    pub derivatives: u64,
    /// Factorisations of it.
    pub factorisations: u64,
}

/// Displacement of the tip that a converged static solve may be off by (its last step, squared for Newton), metres.
const STATIC_TOLERANCE_M: f64 = 1e-8;
/// Smallest share of the loads that continuation raises before the rod is let go instead.
const SMALLEST_SHARE: f64 = 0.02;
/// Iterations after which continuation tries a smaller share.
const CONTINUATION_PATIENCE: usize = 50;

/// A tendon-driven rod.
#[derive(Clone, Debug)]
pub struct Rod {
    pub(super) system: System,
    pub(super) solver: Solver,
    pub(super) state: State,
    /// The state before the step under way, to go back to.
    pub(super) before: State,
    pub(super) motion: Motion,
    pub(super) stages: Vec<Rates>,
    pub(super) tableau: Tableau,
    pub(super) pace: Pace,
    pub(super) tip_load: TipLoad,
    pub(super) space: Space,
    /// Under what the rod came to rest; nothing once it has moved.
    pub(super) rest: Option<Rest>,
    /// What has been solved, for those who follow; nothing is kept when absent.
    pub(super) trace: Option<Trace>,
}

/// What a static solve was asked for.
#[derive(Clone, Debug)]
pub(super) struct Rest {
    pub(super) holds: Vec<Hold>,
    tip_load: TipLoad,
    /// Histories before they came to rest as well.
    pub(super) memory: Vec<Vec<MemoryState>>,
}

/// What has been solved.
#[derive(Clone, Debug, Default)]
pub(super) struct Trace {
    /// Unknowns and taut set of each stage of the step under way.
    pub(super) stages: Vec<(Vec<f64>, Vec<bool>)>,
    /// Equilibria (of infinite duration) and steps that were accepted.
    pub(super) solved: Vec<Solved>,
}

/// A time step or an equilibrium.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) duration_s: f64,
    pub(super) stages: Vec<(Vec<f64>, Vec<bool>)>,
}

impl Trace {
    /// The stages so far were those of a step of `duration_s`.
    pub(super) fn accept(&mut self, duration_s: f64) {
        self.solved.push(Solved { duration_s, stages: std::mem::take(&mut self.stages) });
    }
}

impl Rod {
    /// A rod at rest, straight and unloaded; call [`Rod::settle`] before anything else.
    pub fn new(params: RodParams) -> Rod {
        Rod::on(System::new(params))
    }

    pub(super) fn on(system: System) -> Rod {
        let tip_load = system.params.tip_load;
        let scheme: Scheme = system.params.resolution.scheme;
        let tableau = scheme.tableau();
        let state = State {
            unknowns: vec![0.0; system.size()],
            taut: vec![false; system.params.tendons.len()],
            shape: system.work().shape,
            rates: Rates::zero(&system.grid, &system.masses),
            memory: system.fresh_memory(),
        };
        let mut rod = Rod {
            solver: Solver::new(&system),
            before: state.clone(),
            state,
            motion: Motion::rest(&system.grid, &system.masses),
            stages: tableau.rows.iter().map(|_| Rates::zero(&system.grid, &system.masses)).collect(),
            pace: Pace::new(&tableau),
            tableau,
            tip_load,
            rest: None,
            trace: None,
            space: Space::new(&system),
            system,
        };
        rod.restart();
        rod
    }

    /// Straight, unloaded, at rest, without history.
    pub fn restart(&mut self) {
        self.coarsen();
        self.space.forget();
        self.state.unknowns.fill(0.0);
        self.state.taut.fill(false);
        self.state.memory = self.system.fresh_memory();
        self.state.rates = Rates::zero(&self.system.grid, &self.system.masses);
        let (system, state) = (&self.system, &mut self.state);
        state.shape.update(&system.grid, &system.sections, &state.unknowns[..system.grid.unknowns]);
        self.solver = Solver::new(system);
        self.pace = Pace::new(&self.tableau);
        self.tip_load = system.params.tip_load;
        self.rest = None;
    }

    /// What the rod is made of.
    pub fn params(&self) -> &RodParams {
        &self.system.params
    }

    /// Replaces the load at the tip from now on (it is added to nothing: pass the sum).
    pub fn set_tip_load(&mut self, load: TipLoad) {
        self.tip_load = load;
    }

    /// Brings the rod to rest under `drives` (one a tendon). Histories come to rest as well.
    pub fn settle(&mut self, drives: &[Drive]) -> Status {
        let Some(holds) = self.holds(drives) else { return Status::BadCommand };
        // From rest to rest, histories stay as fine as they are known.
        if self.system.params.memory.is_empty() {
            self.coarsen();
        }
        self.motion = Motion::rest(&self.system.grid, &self.system.masses);
        let before = self.state.clone();
        self.foretell(&holds);
        let mut status = self.solve_static(&holds, 1.0);
        if status != Status::Converged {
            self.state = before.clone();
            status = self.continue_load(&holds);
        }
        if status != Status::Converged {
            self.state.unknowns.fill(0.0);
            self.state.taut.fill(false);
            status = self.relax(&holds, 0.0);
        }
        if status == Status::Converged {
            status = self.examine_rest(&holds);
        }
        if status == Status::Converged {
            self.state.rates = Rates::zero(&self.system.grid, &self.system.masses);
            self.rest = Some(Rest { holds, tip_load: self.tip_load, memory: self.state.memory.clone() });
            self.commit_memory(f64::INFINITY);
            self.trace_stage();
            self.trace.iter_mut().for_each(|trace| trace.accept(f64::INFINITY));
        } else {
            self.state = before;
        }
        status
    }

    /// From rest to rest under the same loads the first residual is known: what the tendons are taken in by. This saves
    /// one evaluation of the equations in four.
    fn foretell(&mut self, holds: &[Hold]) {
        let unchanged = |rest: &&Rest| rest.tip_load == self.tip_load && self.system.params.memory.is_empty();
        if let Some(rest) = self.rest.as_ref().filter(unchanged) {
            self.solver.foretell(&self.system, (&self.state.unknowns, &self.state.taut), (&rest.holds, holds));
        }
    }

    /// Static solve with all loads and pulls at `share` of their value.
    pub(super) fn solve_static(&mut self, holds: &[Hold], share: f64) -> Status {
        let scaled: Vec<Hold> = holds
            .iter()
            .map(|hold| match *hold {
                Hold::Length(pull) => Hold::Length(share * pull),
                Hold::Tension(tension) => Hold::Tension(share * tension),
            })
            .collect();
        let load = TipLoad { force_n: self.tip_load.force_n * share, moment_nm: self.tip_load.moment_nm * share };
        self.seed_tensions(&scaled);
        let gravity = self.system.params.gravity_m_s2 * share;
        self.solve(&scaled, (&load, share), gravity, true, STATIC_TOLERANCE_M)
    }

    /// Raises all loads from nothing in steps that shrink on failure and grow on success.
    fn continue_load(&mut self, holds: &[Hold]) -> Status {
        self.state.unknowns.fill(0.0);
        self.state.taut.fill(false);
        let patience = std::mem::replace(&mut self.solver.patience, CONTINUATION_PATIENCE);
        let status = self.raise_load(holds);
        self.solver.patience = patience;
        status
    }

    fn raise_load(&mut self, holds: &[Hold]) -> Status {
        let (mut reached, mut step) = (0.0, 0.25);
        while reached < 1.0 {
            let target = f64::min(reached + step, 1.0);
            let saved = self.state.clone();
            match self.solve_static(holds, target) {
                Status::Converged => {
                    reached = target;
                    step *= 1.5;
                }
                failure => {
                    self.state = saved;
                    step *= 0.35;
                    if step < SMALLEST_SHARE {
                        return failure;
                    }
                }
            }
        }
        Status::Converged
    }

    pub(super) fn solve(
        &mut self,
        holds: &[Hold],
        (tip_load, load_share): (&TipLoad, f64),
        gravity_m_s2: Vector3<f64>,
        settled: bool,
        tolerance_m: f64,
    ) -> Status {
        let State { unknowns, taut, memory, .. } = &mut self.state;
        let guess = taut.clone();
        let conditions = Conditions {
            holds,
            taut: &guess,
            tip_load,
            load_share,
            gravity_m_s2,
            motion: &self.motion,
            memory,
            settled,
        };
        let status = self.solver.solve(&self.system, unknowns, taut, &conditions, tolerance_m);
        if status == Status::Converged {
            let n = self.system.grid.unknowns;
            // What the tolerance leaves of a push is no tension.
            self.state.unknowns[n..].iter_mut().for_each(|tension| *tension = tension.max(0.0));
            let (system, state) = (&self.system, &mut self.state);
            vectorised(
                #[inline(always)]
                || state.shape.update(&system.grid, &system.sections, &state.unknowns[..n]),
            );
        }
        status
    }

    /// Keeps what has just been solved for those who follow.
    pub(super) fn trace_stage(&mut self) {
        let State { unknowns, taut, .. } = &self.state;
        self.trace.iter_mut().for_each(|trace| trace.stages.push((unknowns.clone(), taut.clone())));
    }

    pub(super) fn commit_memory(&mut self, dt_s: f64) {
        let shape = &self.state.shape;
        for (law, states) in self.system.params.memory.iter().zip(&mut self.state.memory) {
            for (g, state) in states.iter_mut().enumerate() {
                let section = &self.system.sections[g];
                law.commit(state, section.bending(&shape.strain[g]), section.bending_n_m2, dt_s);
            }
        }
    }

    /// Checks the drives and adds the pretension.
    pub(super) fn holds(&self, drives: &[Drive]) -> Option<Vec<Hold>> {
        let tendons = &self.system.params.tendons;
        if drives.len() != tendons.len() {
            return None;
        }
        let hold = |(drive, tendon): (&Drive, &super::tendon::Tendon)| match *drive {
            Drive::Pull(pull) if pull.is_finite() => Some(Hold::Length(pull + tendon.pretension_m)),
            Drive::Tension(tension) if tension.is_finite() && tension >= 0.0 => Some(Hold::Tension(tension)),
            Drive::Follow => Some(Hold::Tension(0.0)),
            _ => None,
        };
        drives.iter().zip(tendons).map(hold).collect()
    }

    /// Known tensions are put in place before the first iteration.
    pub(super) fn seed_tensions(&mut self, holds: &[Hold]) {
        let n = self.system.grid.unknowns;
        for (i, hold) in holds.iter().enumerate() {
            if let Hold::Tension(tension) = *hold {
                self.state.unknowns[n + i] = tension;
                self.state.taut[i] = false;
            }
        }
    }

    /// Tip position in the world frame, metres.
    pub fn tip_m(&self) -> Vector3<f64> {
        self.state.shape.tip_m()
    }

    /// Tip orientation, columns are the body axes.
    pub fn tip_rotation(&self) -> Matrix3<f64> {
        self.state.shape.tip_rotation()
    }

    /// Position (metres) and orientation of the cross-section `position_m` from the base along the relaxed rod, world
    /// frame; the nearest end where the rod has no such place.
    pub fn pose_at(&self, position_m: f64) -> (Vector3<f64>, Matrix3<f64>) {
        self.state.shape.pose_at(&self.system.grid, position_m)
    }

    /// Tendon tensions, N; 0 when slack.
    pub fn tensions_n(&self) -> &[f64] {
        &self.state.unknowns[self.system.grid.unknowns..]
    }

    /// Displacement at which each tendon would be neither slack nor under tension, metres.
    pub fn following_pulls_m(&self) -> Vec<f64> {
        let mut work = self.solver.work.clone();
        work.shape = self.state.shape.clone();
        self.system.update_lengths(&mut work);
        let homes = work.lengths_m.iter().zip(&self.system.home_lengths_m);
        homes.zip(&self.system.params.tendons).map(|((now, home), t)| home - now - t.pretension_m).collect()
    }

    /// What the last solve may be off by at the tip, metres.
    pub fn residual_m(&self) -> f64 {
        self.solver.residual_m
    }

    /// Work done so far.
    pub fn effort(&self) -> Effort {
        let Solver { iterations, derivatives, factorisations, .. } = self.solver;
        Effort { steps: self.pace.taken, iterations, derivatives, factorisations }
    }

    /// The fields along the rod at the Gauss points.
    pub fn cross_sections(&self) -> Vec<CrossSection> {
        let (shape, rates) = (&self.state.shape, &self.state.rates);
        let turning = self.angular_velocities_rad_s();
        let section = |g: usize| {
            let r = shape.node_r[g];
            let wrench = shape.wrench[g];
            CrossSection {
                s_m: self.system.grid.nodes[g].position_m,
                position_m: shape.node_p[g],
                rotation: r,
                moment_nm: r * Vector3::from_row_slice(&wrench[..3]),
                force_n: r * Vector3::from_row_slice(&wrench[3..]),
                velocity_m_s: r.tr_mul(&rates.node_v[g]),
                angular_velocity_rad_s: r.tr_mul(&turning[g]),
            }
        };
        (0..self.system.grid.nodes.len()).map(section).collect()
    }

    /// World-frame angular velocities at the Gauss points, from the rates of curvature below each: ω(s) = ∫ R u_t.
    fn angular_velocities_rad_s(&self) -> Vec<Vector3<f64>> {
        let (shape, rates) = (&self.state.shape, &self.state.rates);
        let rate = |g: usize| shape.node_r[g] * Vector3::from_row_slice(&rates.strain_v[g][..3]);
        let mut below = Vector3::zeros();
        let mut all = Vec::with_capacity(shape.node_r.len());
        for (c, cell) in self.system.grid.cells.iter().enumerate() {
            let both = [rate(2 * c), rate(2 * c + 1)];
            let partial = Grid::partial_weights(cell.length_m);
            all.extend(partial.map(|[first, second]| below + both[0] * first + both[1] * second));
            below += (both[0] + both[1]) * (0.5 * cell.length_m);
        }
        all
    }

    /// Energy now.
    pub fn energy(&self) -> Energy {
        let (shape, rates) = (&self.state.shape, &self.state.rates);
        let gravity = self.system.params.gravity_m_s2;
        let mut energy = Energy { kinetic_j: 0.0, elastic_j: 0.0, gravitational_j: 0.0 };
        for (g, node) in self.system.grid.nodes.iter().enumerate() {
            let section = &self.system.sections[g];
            let mass = section.mass_kg_m * node.weight_m;
            energy.kinetic_j += 0.5 * mass * rates.node_v[g].norm_squared();
            energy.gravitational_j -= mass * gravity.dot(&shape.node_p[g]);
            energy.elastic_j += node.weight_m * section.energy_j_m(&shape.wrench[g]);
        }
        for (k, mass) in self.system.masses.iter().enumerate() {
            energy.kinetic_j += 0.5 * mass.mass_kg * rates.mass_v[k].norm_squared();
            let spin = rates.spin[k];
            energy.kinetic_j += 0.5 * spin.dot(&mass.inertia_kg_m2.component_mul(&spin));
            energy.gravitational_j -= mass.mass_kg * gravity.dot(&shape.end_p[mass.end]);
        }
        for (tension, tendon) in self.tensions_n().iter().zip(&self.system.params.tendons) {
            energy.elastic_j += 0.5 * tendon.compliance_m_per_n * tension * tension;
        }
        energy
    }
}
