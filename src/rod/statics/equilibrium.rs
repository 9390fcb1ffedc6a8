//! Static equilibrium under given tendon commands and loads.

use crate::rod::equations::boundary_conditions::TendonConstraint;
use crate::rod::equations::motion::Motion;
use crate::rod::params::tendon::Tendon;
use crate::rod::solver::active_set::ConstraintChange;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rates::Rates;
use crate::rod::state::rest::SettledConditions;
use crate::rod::state::rod::{Drive, Rod};

use super::stable_branch::RestBefore;

impl Rod {
    /// Brings the rod to rest under `drives`, one per tendon. Histories relax completely,
    /// in the first rest after a restart for [`RodParams::rested_s`].
    ///
    /// [`RodParams::rested_s`]: crate::rod::RodParams::rested_s
    pub fn settle(&mut self, drives: &[Drive]) -> SolveStatus {
        let Some(constraints) = self.constraints(drives) else { return SolveStatus::BadCommand };
        let under = self.settled_under.take();
        // With histories the refined grid is kept between equilibria, so that they keep their
        // resolution.
        if self.system.params.moment_laws.is_empty() {
            self.coarsen();
        }
        self.motion = Motion::rest(&self.system.grid, &self.system.masses);
        let before = RestBefore { state: self.state.clone(), under };
        self.predict_residual(&constraints, before.under.as_ref());
        // Three ways to an equilibrium (docs/method/robustness.md): from where the rod stands …
        let mut status = self.solve_static(&constraints, 1.0);
        if status != SolveStatus::Converged {
            // … with all loads raised together …
            self.state.copy_from(&before.state);
            status = self.continue_in_load(&constraints);
        }
        if status != SolveStatus::Converged {
            // … and as an overdamped rod that is followed to rest.
            self.state.unknowns.fill(0.0);
            self.state.taut.fill(false);
            status = self.relax_dynamically(&constraints, 0.0);
        }
        if status == SolveStatus::Converged {
            status = self.verify_equilibrium(&constraints, &before);
        }
        if status.is_equilibrium() {
            self.state.rates = Rates::zero(&self.system.grid, &self.system.masses);
            // At rest, time that was too short for a step has passed without effect.
            self.step_size.owed_s = 0.0;
            self.settled_under = Some(SettledConditions {
                constraints,
                tip_load: self.tip_load,
                // Before the commit: derivatives at this rest need what the solve started from.
                histories: self.state.histories.clone(),
                sliding: self.state.sliding.clone(),
                contact_memory: self.state.contact_memory.clone(),
                rested_s: self.state.rested_s,
            });
            self.commit_histories(f64::INFINITY);
            self.log_stage();
            self.log.iter_mut().for_each(|log| log.accept(f64::INFINITY));
        } else {
            // A failed solve leaves the rod as it was.
            self.state = before.state;
            self.settled_under = before.under;
        }
        status
    }

    /// Between equilibria under the same loads the first residual is known: the change of the
    /// tendon constraints. This saves one evaluation of the equations in four.
    fn predict_residual(
        &mut self,
        constraints: &[TendonConstraint],
        before: Option<&SettledConditions>,
    ) {
        let params = &self.system.params;
        let remembers =
            !params.moment_laws.is_empty() || params.tendons.iter().any(Tendon::has_friction);
        let same_load = |rest: &&SettledConditions| rest.tip_load == self.tip_load && !remembers;
        if let Some(rest) = before.filter(same_load) {
            let change = ConstraintChange { from: &rest.constraints, to: constraints };
            self.solver.predict_residual(
                &self.system,
                &self.state.unknowns,
                &self.state.taut,
                &change,
            );
        }
    }
}
