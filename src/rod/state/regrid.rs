//! The same rod on the grid of another refinement level.

use super::rod::Rod;

impl Rod {
    /// Estimated tip error due to the spatial discretisation, metres. After a static solve: the
    /// larger of the estimate and the error found by reconstruction. In motion: the estimate.
    pub fn space_error_m(&self) -> f64 {
        self.grid_level.error_m
    }

    /// Refinements beyond the requested resolution.
    pub fn refinements(&self) -> u32 {
        self.grid_level.level
    }

    /// Returns to the requested resolution and transfers the state, histories included.
    pub(crate) fn coarsen(&mut self) {
        if self.grid_level.level > 0 {
            *self = self.on_grid(0);
        }
    }

    /// The same rod in the same state on the grid of another level, at rest.
    pub(crate) fn on_grid(&self, level: u32) -> Rod {
        self.with_state_on(
            Rod::new(self.system.params.refined(&self.grid_level.base, level)),
            level,
        )
    }

    /// `rod`, on the grid of another level, in the state of this one.
    pub(crate) fn with_state_on(&self, mut rod: Rod, level: u32) -> Rod {
        rod.log.clone_from(&self.log);
        rod.grid_level.level = level;
        rod.grid_level.error_m = self.grid_level.error_m;
        rod.grid_level.base = self.grid_level.base;
        rod.tip_load = self.tip_load;
        rod.branch = self.branch;
        let (from, to) = (&self.system.grid, &rod.system.grid);
        to.transfer(from, &self.state.unknowns, &mut rod.state.unknowns);
        rod.state.taut.clone_from(&self.state.taut);
        rod.state.histories = self
            .state
            .histories
            .iter()
            .map(|states| to.interpolate_histories(from, states))
            .collect();
        rod.state.sliding.clone_from(&self.state.sliding);
        rod.state.contact_memory.clone_from(&self.state.contact_memory);
        rod.state.rested_s = self.state.rested_s;
        rod.state.shape.update(to, &rod.system.sections, &rod.state.unknowns[..to.unknowns]);
        // Effort counts on across grids.
        rod.solver.iterations = self.solver.iterations;
        rod.solver.derivatives = self.solver.derivatives;
        rod.solver.factorisations = self.solver.factorisations;
        rod
    }
}
