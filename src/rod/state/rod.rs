//! A rod that can be settled and moved: the interface of this room.

use nalgebra::{Matrix3, Vector3};

use crate::rod::params::scheme::{Scheme, Tableau};
use super::solve_log::Trace;
use crate::rod::dynamics::time_stepping::Pace;
use crate::rod::equations::boundary_conditions::{Conditions, Hold};
use crate::rod::equations::motion::Motion;
use crate::rod::equations::system::System;
use crate::rod::params::rod_params::{RodParams, TipLoad};
use crate::rod::solver::Solver;
use super::rod_state::{Rates, State};
use crate::rod::statics::equilibrium::Rest;
use crate::rod::statics::refinement::Space;
use crate::rod::solver::status::Status;
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

/// A tendon-driven rod.
#[derive(Clone, Debug)]
pub struct Rod {
    pub(crate) system: System,
    pub(crate) solver: Solver,
    pub(crate) state: State,
    /// The state before the step under way, to go back to.
    pub(crate) before: State,
    pub(crate) motion: Motion,
    pub(crate) stages: Vec<Rates>,
    pub(crate) tableau: Tableau,
    pub(crate) pace: Pace,
    pub(crate) tip_load: TipLoad,
    pub(crate) space: Space,
    /// Under what the rod came to rest; nothing once it has moved.
    pub(crate) rest: Option<Rest>,
    /// What has been solved, for those who follow; nothing is kept when absent.
    pub(crate) trace: Option<Trace>,
}

impl Rod {
    /// A rod at rest, straight and unloaded; call [`Rod::settle`] before anything else.
    pub fn new(params: RodParams) -> Rod {
        Rod::on(System::new(params))
    }

    pub(crate) fn on(system: System) -> Rod {
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

    pub(crate) fn solve(
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

    pub(crate) fn commit_memory(&mut self, dt_s: f64) {
        let shape = &self.state.shape;
        for (law, states) in self.system.params.memory.iter().zip(&mut self.state.memory) {
            for (g, state) in states.iter_mut().enumerate() {
                let section = &self.system.sections[g];
                law.commit(state, section.bending(&shape.strain[g]), section.bending_n_m2, dt_s);
            }
        }
    }

    /// Checks the drives and adds the pretension.
    pub(crate) fn holds(&self, drives: &[Drive]) -> Option<Vec<Hold>> {
        let tendons = &self.system.params.tendons;
        if drives.len() != tendons.len() {
            return None;
        }
        let hold = |(drive, tendon): (&Drive, &crate::rod::params::tendon::Tendon)| match *drive {
            Drive::Pull(pull) if pull.is_finite() => Some(Hold::Length(pull + tendon.pretension_m)),
            Drive::Tension(tension) if tension.is_finite() && tension >= 0.0 => Some(Hold::Tension(tension)),
            Drive::Follow => Some(Hold::Tension(0.0)),
            _ => None,
        };
        drives.iter().zip(tendons).map(hold).collect()
    }

    /// Known tensions are put in place before the first iteration.
    pub(crate) fn seed_tensions(&mut self, holds: &[Hold]) {
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
        let lengths_m = self.system.lengths_m(&self.state.shape);
        let homes = lengths_m.iter().zip(&self.system.home_lengths_m);
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
}
