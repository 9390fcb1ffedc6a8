//! The state of a rod at one instant.

use super::rates::Rates;
use crate::rod::equations::boundary_conditions::{AppliedLoads, SolveConditions, TendonConstraint};
use crate::rod::equations::contact::ContactMemory;
use crate::rod::equations::motion::Motion;
use crate::rod::equations::shape::Shape;
use crate::rod::equations::tendon_friction::TendonSliding;
use crate::rod::params::hysteresis_law::HistoryState;

/// Position, velocity and history of a rod at one instant.
#[derive(Clone, Debug, Default)]
pub(crate) struct RodState {
    /// Polynomial coefficients, then tensions.
    pub(crate) unknowns: Vec<f64>,
    pub(crate) taut: Vec<bool>,
    pub(crate) shape: Shape,
    pub(crate) rates: Rates,
    pub(crate) histories: Vec<Vec<HistoryState>>,
    /// Sliding of the tendons in their guides.
    pub(crate) sliding: Vec<TendonSliding>,
    /// What the friction of contacts remembers.
    pub(crate) contact_memory: ContactMemory,
    /// Duration of the next rest, s.
    pub(crate) rested_s: f64,
}

impl RodState {
    /// The conditions of a solve that goes on from this state, with the tendons taut that are taut
    /// now.
    pub(crate) fn conditions<'a>(
        &'a self,
        motion: &'a Motion,
        constraints: &'a [TendonConstraint],
        loads: &'a AppliedLoads,
        at_rest: bool,
    ) -> SolveConditions<'a> {
        SolveConditions {
            constraints,
            taut: &self.taut,
            loads,
            motion,
            histories: &self.histories,
            sliding: &self.sliding,
            contact_memory: &self.contact_memory,
            fixed_touches: None,
            obstacle_share: 1.0,
            at_rest,
            rested_s: self.rested_s,
        }
    }

    /// Copies `other` without allocating.
    pub(crate) fn copy_from(&mut self, other: &RodState) {
        self.unknowns.clone_from(&other.unknowns);
        self.taut.clone_from(&other.taut);
        self.shape.copy_from(&other.shape);
        self.rates.copy_from(&other.rates);
        self.histories.clone_from(&other.histories);
        self.sliding.clone_from(&other.sliding);
        self.contact_memory.clone_from(&other.contact_memory);
        self.rested_s = other.rested_s;
    }
}
