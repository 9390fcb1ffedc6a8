//! Equilibria: a rod is brought to rest under what its tendons are told and what loads it.

use crate::rod::equations::boundary_conditions::Hold;
use crate::rod::params::hysteresis_law::MemoryState;
use crate::rod::equations::motion::Motion;
use crate::rod::params::rod_params::TipLoad;
use crate::rod::state::rod::{Drive, Rod};
use crate::rod::state::rod_state::Rates;
use crate::rod::solver::status::Status;

/// Displacement of the tip that a converged static solve may be off by (its last step, squared for Newton), metres.
const STATIC_TOLERANCE_M: f64 = 1e-8;
/// Smallest share of the loads that continuation raises before the rod is let go instead.
const SMALLEST_SHARE: f64 = 0.02;
/// Iterations after which continuation tries a smaller share.
const CONTINUATION_PATIENCE: usize = 50;

/// What a static solve was asked for.
#[derive(Clone, Debug)]
pub(crate) struct Rest {
    pub(crate) holds: Vec<Hold>,
    tip_load: TipLoad,
    /// Histories before they came to rest as well.
    pub(crate) memory: Vec<Vec<MemoryState>>,
}

impl Rod {
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
    pub(crate) fn solve_static(&mut self, holds: &[Hold], share: f64) -> Status {
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
}
