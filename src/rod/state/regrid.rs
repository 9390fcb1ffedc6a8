//! The same rod on the grid of another refinement level.

use super::rod::Rod;

impl Rod {
    /// What the discretisation in space may put the tip off by, metres: after a static solve the larger one of an estimate
    /// and of what a reconstruction says; in motion an estimate.
    pub fn space_error_m(&self) -> f64 {
        self.grid_level.error_m
    }

    /// How often the grid has been refined beyond the resolution that was asked for.
    pub fn refinements(&self) -> u32 {
        self.grid_level.level
    }

    /// Goes back to the resolution that was asked for; histories along the rod are taken along.
    pub(crate) fn coarsen(&mut self) {
        if self.grid_level.level > 0 {
            *self = self.on_grid(0);
        }
    }

    /// The same rod in the same state on the grid of another level, at rest.
    pub(crate) fn on_grid(&self, level: u32) -> Rod {
        self.with_state_on(Rod::new(self.system.params.refined(&self.grid_level.base, level)), level)
    }

    /// `rod`, on the grid of another level, in the state of this one.
    pub(crate) fn with_state_on(&self, mut rod: Rod, level: u32) -> Rod {
        rod.log.clone_from(&self.log);
        rod.grid_level.level = level;
        rod.grid_level.error_m = self.grid_level.error_m;
        rod.grid_level.base = self.grid_level.base;
        rod.tip_load = self.tip_load;
        let (from, to) = (&self.system.grid, &rod.system.grid);
        to.transfer(from, &self.state.unknowns, &mut rod.state.unknowns);
        rod.state.taut.clone_from(&self.state.taut);
        rod.state.histories =
            self.state.histories.iter().map(|states| to.interpolate_histories(from, states)).collect();
        rod.state.shape.update(to, &rod.system.sections, &rod.state.unknowns[..to.unknowns]);
        rod.solver.iterations = self.solver.iterations;
        rod.solver.derivatives = self.solver.derivatives;
        rod.solver.factorisations = self.solver.factorisations;
        rod
    }
}
