//! What has been solved, kept for the rods that follow another one.

use super::simulation::Rod;
use super::state::State;

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
    /// Keeps what has just been solved for those who follow.
    pub(super) fn trace_stage(&mut self) {
        let State { unknowns, taut, .. } = &self.state;
        self.trace.iter_mut().for_each(|trace| trace.stages.push((unknowns.clone(), taut.clone())));
    }
}
