//! How a recurrent inverse mapping is asked: when its memory moves on, and how far ahead it is
//! asked to go.

use serde::{Deserialize, Serialize};

use super::model_traits::InverseModel;
use crate::base::{BadOption, Displacements, Point3, PolicyError, distance_m};

/// Update of the memory of a recurrent network.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum MemoryUpdate {
    /// At each control tick, with or without a new measurement: open and closed loop differ only in
    /// the measured input.
    #[default]
    EveryTick,
    /// At each new measurement: no update in open loop.
    Measured,
    /// Never: each evaluation starts from the reset state.
    Rest,
}

/// Evaluation of the networks; the same for every policy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NetworkOptions {
    /// Update of the memory.
    pub memory: MemoryUpdate,
    /// Largest distance of the point passed to the network from the current one, on the line to the
    /// target; `null` passes the target itself, as in eq. (22). Applies only to new measurements:
    /// open loop passes the target.
    pub lookahead_m: Option<f64>,
}

impl NetworkOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive_or_null("lookahead_m", self.lookahead_m)
    }

    /// The point that the network is asked for.
    pub(crate) fn aim_m(&self, from_m: &Point3, to_m: &Point3, fresh: bool) -> Point3 {
        let Some(reach_m) = self.lookahead_m.filter(|_| fresh) else { return *to_m };
        let share = (reach_m / distance_m(from_m, to_m)).min(1.0);
        std::array::from_fn(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]))
    }
}

/// A network and when its memory moves.
pub(crate) struct RecurrentInverse {
    model: Box<dyn InverseModel>,
    memory: MemoryUpdate,
    /// Whether the network was evaluated since the last tick began.
    consulted: bool,
}

impl RecurrentInverse {
    pub(crate) fn new(model: Box<dyn InverseModel>, memory: MemoryUpdate) -> Self {
        let mut network = RecurrentInverse { model, memory, consulted: false };
        network.reset();
        network
    }

    pub(crate) fn reset(&mut self) {
        self.model.reset();
        self.consulted = false;
    }

    /// Begins a control tick.
    pub(crate) fn begin(&mut self, fresh: bool) {
        let moves_on = match self.memory {
            MemoryUpdate::Measured => fresh,
            MemoryUpdate::EveryTick => true,
            MemoryUpdate::Rest => false,
        };
        if self.consulted && moves_on {
            self.model.tick();
        }
        self.consulted = false;
    }

    /// Finite displacements from the network, metres.
    pub(crate) fn pulls(
        &mut self,
        from_m: &Point3,
        to_m: &Point3,
    ) -> Result<Displacements, PolicyError> {
        let pulls_m = self.model.pulls(from_m, to_m)?;
        self.consulted = true;
        PolicyError::unless_finite("output of the inverse network", &pulls_m)?;
        Ok(pulls_m)
    }
}
