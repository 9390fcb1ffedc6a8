//! Log of solves, for the rods that follow another one.

/// Solved stages and steps.
#[derive(Clone, Debug, Default)]
pub(crate) struct SolveLog {
    /// Stages of the step under way.
    pub(crate) stages: Vec<SolvedStage>,
    /// Equilibria (of infinite duration) and steps that were accepted.
    pub(crate) solved: Vec<SolvedStep>,
}

/// A time step or an equilibrium.
#[derive(Clone, Debug)]
pub(crate) struct SolvedStep {
    pub(crate) duration_s: f64,
    pub(crate) stages: Vec<SolvedStage>,
}

/// The solution of one stage.
#[derive(Clone, Debug)]
pub(crate) struct SolvedStage {
    pub(crate) unknowns: Vec<f64>,
    pub(crate) taut: Vec<bool>,
}

impl SolveLog {
    /// Closes a step of `duration_s` with the stages logged so far.
    pub(crate) fn accept(&mut self, duration_s: f64) {
        self.solved.push(SolvedStep { duration_s, stages: std::mem::take(&mut self.stages) });
    }
}
