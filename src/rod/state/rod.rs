//! The tendon-driven rod: parameters, equations, solver and state.

use super::branch::RestBranch;
use super::grid_level::GridLevel;
use super::rates::Rates;
use super::rest::SettledConditions;
use super::rod_state::RodState;
use super::solve_log::{SolveLog, SolvedStage};
use super::step_size::StepSize;
use crate::math::vectorised;
use crate::rod::equations::boundary_conditions::{AppliedLoads, SolveConditions, TendonConstraint};
use crate::rod::equations::contact::ContactMemory;
use crate::rod::equations::motion::Motion;
use crate::rod::equations::system::RodEquations;
use crate::rod::params::loads::TipWrench;
use crate::rod::params::rod_params::RodParams;
use crate::rod::params::scheme::{Scheme, Tableau};
use crate::rod::params::tendon::Tendon;
use crate::rod::solver::newton_state::NewtonSolver;
use crate::rod::solver::status::SolveStatus;

/// Command to one tendon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Displacement at the drive in metres, 0 at home, positive pulls; the tendon never pushes.
    Pull(f64),
    /// Tension in newtons, ≥ 0.
    Tension(f64),
    /// Zero tension without slack: the drive follows the shape.
    Follow,
}

/// A tendon-driven rod.
#[derive(Clone, Debug)]
pub struct Rod {
    pub(crate) system: RodEquations,
    pub(crate) solver: NewtonSolver,
    pub(crate) state: RodState,
    /// The state before the current step.
    pub(crate) before: RodState,
    pub(crate) motion: Motion,
    pub(crate) stages: Vec<Rates>,
    pub(crate) tableau: Tableau,
    pub(crate) step_size: StepSize,
    pub(crate) tip_load: TipWrench,
    pub(crate) grid_level: GridLevel,
    /// Share of the stiffness of obstacles.
    pub(crate) obstacle_share: f64,
    /// How the present equilibrium is connected with the one before.
    pub(crate) branch: RestBranch,
    /// Commands and loads of the present equilibrium; `None` once the rod has moved.
    pub(crate) settled_under: Option<SettledConditions>,
    /// Log of solves for rods that follow this one; `None` when nothing follows.
    pub(crate) log: Option<SolveLog>,
}

impl Rod {
    /// A rod at rest, straight and unloaded; call [`Rod::settle`] before anything else.
    pub fn new(params: RodParams) -> Rod {
        Rod::on(RodEquations::new(params))
    }

    pub(crate) fn on(system: RodEquations) -> Rod {
        let tip_load = system.params.tip_load;
        let scheme: Scheme = system.params.resolution.scheme;
        let tableau = scheme.tableau();
        let state = RodState {
            unknowns: vec![0.0; system.size()],
            taut: vec![false; system.params.tendons.len()],
            shape: system.workspace().shape,
            rates: Rates::zero(&system.grid, &system.masses),
            histories: system.virgin_histories(),
            sliding: system.tendons_at_home(),
            contact_memory: ContactMemory::default(),
            rested_s: f64::INFINITY,
        };
        let mut rod = Rod {
            solver: NewtonSolver::new(&system),
            before: state.clone(),
            state,
            motion: Motion::rest(&system.grid, &system.masses),
            stages: tableau
                .rows
                .iter()
                .map(|_| Rates::zero(&system.grid, &system.masses))
                .collect(),
            step_size: StepSize::new(&tableau),
            tableau,
            tip_load,
            obstacle_share: 1.0,
            branch: RestBranch::Same,
            settled_under: None,
            log: None,
            grid_level: GridLevel::new(&system),
            system,
        };
        rod.restart();
        rod
    }

    /// Straight, unloaded, at rest, without history.
    pub fn restart(&mut self) {
        self.coarsen();
        self.grid_level.confirmed = None;
        self.state.unknowns.fill(0.0);
        self.state.taut.fill(false);
        self.state.histories = self.system.virgin_histories();
        self.state.sliding = self.system.tendons_at_home();
        self.state.contact_memory = ContactMemory::default();
        self.state.rates = Rates::zero(&self.system.grid, &self.system.masses);
        let (system, state) = (&self.system, &mut self.state);
        state.shape.update(&system.grid, &system.sections, &state.unknowns[..system.grid.unknowns]);
        self.solver = NewtonSolver::new(system);
        self.step_size = StepSize::new(&self.tableau);
        self.tip_load = system.params.tip_load;
        self.state.rested_s = system.params.rested_s;
        self.settled_under = None;
    }

    /// Makes the next rest one for good, whatever the parameters say.
    pub(crate) fn rest_for_good(&mut self) {
        self.state.rested_s = f64::INFINITY;
    }

    /// What the rod is made of.
    pub fn params(&self) -> &RodParams {
        &self.system.params
    }

    /// Replaces the load at the tip. The load is not added to an earlier one: pass the sum.
    pub fn set_tip_load(&mut self, load: TipWrench) {
        self.tip_load = load;
    }

    /// All loads at their full value.
    pub(crate) fn full_loads(&self) -> AppliedLoads {
        AppliedLoads {
            tip: self.tip_load,
            share: 1.0,
            gravity_m_s2: self.system.params.gravity_m_s2,
        }
    }

    /// Solves the equations from the present unknowns.
    pub(crate) fn solve(
        &mut self,
        constraints: &[TendonConstraint],
        loads: &AppliedLoads,
        at_rest: bool,
        tolerance_m: f64,
    ) -> SolveStatus {
        let RodState { unknowns, taut, histories, sliding, contact_memory, rested_s, .. } =
            &mut self.state;
        // The solver borrows the set mutably while the conditions hold its initial guess.
        let guess = taut.clone();
        let conditions = SolveConditions {
            constraints,
            taut: &guess,
            loads,
            motion: &self.motion,
            histories,
            sliding,
            contact_memory,
            fixed_touches: None,
            obstacle_share: self.obstacle_share,
            at_rest,
            rested_s: *rested_s,
        };
        let status = self.solver.solve(&self.system, unknowns, taut, &conditions, tolerance_m);
        if status == SolveStatus::Converged {
            let n = self.system.grid.unknowns;
            // A tension that is negative within the tolerance is zero.
            self.state.unknowns[n..].iter_mut().for_each(|tension| *tension = tension.max(0.0));
            let (system, state) = (&self.system, &mut self.state);
            vectorised!(state.shape.update(&system.grid, &system.sections, &state.unknowns[..n]));
        }
        status
    }

    /// Evaluates the equations at the present unknowns, and their derivative with D and M.
    pub(crate) fn refresh(
        &mut self,
        constraints: &[TendonConstraint],
        loads: &AppliedLoads,
        at_rest: bool,
    ) {
        let Rod { system, solver, state, motion, obstacle_share, .. } = self;
        let conditions = state.conditions(motion, constraints, loads, at_rest);
        let conditions = SolveConditions { obstacle_share: *obstacle_share, ..conditions };
        solver.refresh(system, &state.unknowns, &conditions);
    }

    /// Ends a step of `dt_s` seconds (infinite: at rest) for everything that remembers, at the last
    /// evaluation of the equations.
    pub(crate) fn commit_histories(&mut self, dt_s: f64) {
        let rested_s = std::mem::replace(&mut self.state.rested_s, f64::INFINITY);
        let dt_s = if dt_s.is_infinite() { rested_s } else { dt_s };
        self.state.sliding.copy_from_slice(&self.solver.workspace.sliding);
        let RodState { shape, contact_memory, .. } = &mut self.state;
        contact_memory.commit(
            &self.system.params.contact,
            &self.system.grid,
            shape,
            &self.solver.workspace.touches,
        );
        let shape = &self.state.shape;
        for (law, states) in self.system.params.moment_laws.iter().zip(&mut self.state.histories) {
            for (g, state) in states.iter_mut().enumerate() {
                if !law.acts_at(self.system.grid.nodes[g].position_m) {
                    continue;
                }
                let section = &self.system.sections[g];
                law.commit(state, section.bending(&shape.strain[g]), section.bending_n_m2, dt_s);
            }
        }
    }

    /// Checks the drives and adds the pretension.
    pub(crate) fn constraints(&self, drives: &[Drive]) -> Option<Vec<TendonConstraint>> {
        let tendons = &self.system.params.tendons;
        if drives.len() != tendons.len() {
            return None;
        }
        let constraint = |(drive, tendon): (&Drive, &Tendon)| match *drive {
            Drive::Pull(pull) if pull.is_finite() => {
                Some(TendonConstraint::Length(pull + tendon.pretension_m))
            }
            Drive::Tension(tension) if tension.is_finite() && tension >= 0.0 => {
                Some(TendonConstraint::Tension(tension))
            }
            // A drive that follows the shape never loads its tendon.
            Drive::Follow => Some(TendonConstraint::Tension(0.0)),
            _ => None,
        };
        drives.iter().zip(tendons).map(constraint).collect()
    }

    /// Sets prescribed tensions before the first iteration.
    pub(crate) fn seed_tensions(&mut self, constraints: &[TendonConstraint]) {
        let n = self.system.grid.unknowns;
        for (i, constraint) in constraints.iter().enumerate() {
            if let TendonConstraint::Tension(tension) = *constraint {
                self.state.unknowns[n + i] = tension;
                // The active set is for tendons that are held by length.
                self.state.taut[i] = false;
            }
        }
    }

    /// Logs the stage that has just been solved.
    pub(crate) fn log_stage(&mut self) {
        let RodState { unknowns, taut, .. } = &self.state;
        let stage = |log: &mut SolveLog| {
            log.stages.push(SolvedStage { unknowns: unknowns.clone(), taut: taut.clone() })
        };
        self.log.iter_mut().for_each(stage);
    }
}
