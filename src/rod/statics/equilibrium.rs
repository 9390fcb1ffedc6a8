//! Equilibria: a rod is brought to rest under what its tendons are told and what loads it.

use crate::rod::equations::boundary_conditions::Hold;
use crate::rod::equations::motion::Motion;
use crate::rod::solver::status::Status;
use crate::rod::state::rates::Rates;
use crate::rod::state::rest::Rest;
use crate::rod::state::rod::{Drive, Rod};

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
}
