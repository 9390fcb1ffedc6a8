//! The kinds of networks. A kind is the formulas of one hidden unit (one file) and its line in the
//! registry; products with weights, back-propagation through time, training, storage and use are
//! common to all.

use serde::{Deserialize, Serialize};

use super::batch::SequenceBatch;
use super::member::MemberState;
use super::weights::Weights;
use crate::learn::simd::Real;

/// Most sums of a unit.
pub(super) const MAX_SUMS: usize = 4;

/// Most numbers that a unit keeps for the way back.
pub(super) const MAX_SAVED: usize = 5;

/// A weighted sum that a unit takes, with a bias of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WeightedSum {
    /// Whether it sees the inputs.
    pub(super) inputs: bool,
    /// Whether it sees the units' previous values.
    pub(super) state: bool,
}

impl WeightedSum {
    pub(super) const INPUTS: WeightedSum = WeightedSum { inputs: true, state: false };
    pub(super) const STATE: WeightedSum = WeightedSum { inputs: false, state: true };
    pub(super) const BOTH: WeightedSum = WeightedSum { inputs: true, state: true };
}

/// What a step makes of a unit.
pub(super) struct Forward<T> {
    /// The unit's value.
    pub(super) value: T,
    /// Its memory, where the kind has one.
    pub(super) memory: T,
    /// What [`HiddenUnit::backward`] wants to see again.
    pub(super) saved: [T; MAX_SAVED],
}

/// What [`HiddenUnit::backward`] starts from.
pub(super) struct Past<T> {
    /// The unit's value after the step.
    pub(super) value: T,
    /// Its value before.
    pub(super) value_before: T,
    /// Its memory before.
    pub(super) memory_before: T,
    /// What the step kept.
    pub(super) saved: [T; MAX_SAVED],
    /// ∂loss/∂value after the step.
    pub(super) d_value: T,
    /// ∂loss/∂memory after the step, by way of later steps.
    pub(super) d_memory: T,
}

/// Derivatives of the loss with respect to what a step started from.
pub(super) struct Backward<T> {
    /// With respect to the sums.
    pub(super) d_sums: [T; MAX_SUMS],
    /// With respect to the value before, not by way of the sums.
    pub(super) d_value_before: T,
    /// With respect to the memory before.
    pub(super) d_memory_before: T,
}

/// The formulas of a hidden unit.
pub(super) trait HiddenUnit {
    /// Its sums, at most [`MAX_SUMS`].
    const SUMS: &'static [WeightedSum];
    /// How many numbers it keeps for the way back, at most [`MAX_SAVED`].
    const SAVED: usize = 0;
    /// Whether it has a memory beside its value.
    const MEMORY: bool = false;
    /// Whether its value before enters other than by way of the sums.
    const CARRIES: bool = false;

    /// One step.
    fn forward<T: Real>(sums: &[T; MAX_SUMS], value_before: T, memory_before: T) -> Forward<T>;

    /// Its derivatives.
    fn backward<T: Real>(past: &Past<T>) -> Backward<T>;
}

macro_rules! kinds {
    ($($(#[$note:meta])* $module:ident::$kind:ident),* $(,)?) => {
        $(mod $module;)*

        /// Kind of a network's hidden layer.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum NetworkKind { $($(#[$note])* $kind),* }

        impl NetworkKind {
            /// Every kind.
            pub const ALL: &'static [NetworkKind] = &[$(NetworkKind::$kind),*];

            pub(super) fn weighted_sums(self) -> &'static [WeightedSum] {
                match self { $(NetworkKind::$kind => $module::$kind::SUMS),* }
            }

            pub(super) fn saved(self) -> usize {
                match self { $(NetworkKind::$kind => $module::$kind::SAVED),* }
            }

            pub(super) fn has_memory(self) -> bool {
                match self { $(NetworkKind::$kind => $module::$kind::MEMORY),* }
            }

            pub(super) fn carries(self) -> bool {
                match self { $(NetworkKind::$kind => $module::$kind::CARRIES),* }
            }

            /// One step of a network of this kind.
            pub(super) fn advance(self) -> fn(&Weights<f32>, &mut MemberState, &[f32], &mut [f32]) {
                match self { $(NetworkKind::$kind => MemberState::advance::<$module::$kind>),* }
            }

            /// Loss and gradient of a batch of a network of this kind.
            pub(super) fn work<T: Real>(self) -> fn(&mut SequenceBatch<T>, &Weights<T>, &mut Weights<T>) -> T {
                match self { $(NetworkKind::$kind => SequenceBatch::work::<$module::$kind>),* }
            }
        }
    };
}

kinds! {
    /// Units with feedback of their previous values (Elman 1990; the paper's).
    #[default]
    elman::Elman,
    /// Gated recurrent units (Cho et al. 2014).
    gru::Gru,
    /// Long short-term memory (Hochreiter & Schmidhuber 1997, with the forget gate of Gers et al.
    /// 2000).
    lstm::Lstm,
    /// Units without memory, on the last rows of inputs.
    feed_forward::FeedForward,
}

impl NetworkKind {
    /// Rows of inputs that a network of this kind sees where `history` is not set.
    pub(super) fn default_history(self) -> usize {
        if self.remembers() { 1 } else { 4 }
    }

    /// Whether units see previous values at all.
    pub(super) fn remembers(self) -> bool {
        self.weighted_sums().iter().any(|block| block.state)
    }
}

/// Logistic function.
#[inline(always)]
fn sigmoid<T: Real>(x: T) -> T {
    let half = T::of(0.5);
    // σ(x) = (1 + tanh(x/2)) / 2: one function for all units.
    half.fma((half * x).tanh_fast(), half)
}
