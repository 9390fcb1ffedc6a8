//! The trained network.

use serde::{Deserialize, Serialize};

use super::history::InputHistory;
use super::kinds::NetworkKind;
use super::member::MemberState;
use super::weights::{Sizes, Weights};
use crate::base::Rows;
use crate::learn::standardise::check_finite;
use crate::learn::{LearnError, Standardiser, exact};

/// A network of one hidden layer with a linear output layer (the paper's is Elman's: IV-A, eqs 17
/// and 21), or the mean of several such networks, its members. Inputs and outputs are in their own
/// units; standardising is inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StoredNetwork", into = "StoredNetwork")]
pub struct Network {
    pub(super) sizes: Sizes,
    /// Rows of inputs that it sees at a step.
    pub(super) history: usize,
    /// The members' weights.
    pub(super) members: Vec<Weights<f32>>,
    pub(super) inputs: Standardiser,
    pub(super) outputs: Standardiser,
    /// False for a network trained on single rows: its recurrent weights are not used.
    pub(super) recurrent: bool,
}

/// What a network knows between two steps.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkState {
    history: InputHistory,
    members: Vec<MemberState>,
    /// Room for a member's standardised outputs.
    answer: Vec<f32>,
}

impl NetworkState {
    /// Resets to the state at rest.
    pub fn reset(&mut self) {
        self.history.reset();
        self.members.iter_mut().for_each(MemberState::reset);
    }
}

impl Network {
    /// The state at rest.
    pub fn state(&self) -> NetworkState {
        NetworkState {
            history: InputHistory::new(self.inputs(), self.history),
            members: vec![MemberState::new(self.sizes); self.members.len()],
            answer: vec![0.0; self.outputs()],
        }
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.inputs.width()
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.sizes.outputs
    }

    /// Hidden units of a member.
    pub fn hidden(&self) -> usize {
        self.sizes.hidden
    }

    /// Kind of the hidden layer.
    pub fn kind(&self) -> NetworkKind {
        self.sizes.kind
    }

    /// Number of members.
    pub fn members(&self) -> usize {
        self.members.len()
    }

    /// One step: reads `input`, moves `state` on and writes the outputs, all in their own units.
    ///
    /// # Errors
    /// Wrong widths, or an input that is not finite (the state is then left as it was).
    pub fn step(
        &self,
        state: &mut NetworkState,
        input: &[f64],
        out: &mut [f64],
    ) -> Result<(), LearnError> {
        let sums = state.members.first().map_or(0, |member| member.sums.len());
        LearnError::unless_shape("columns of a query", input.len(), self.inputs())?;
        LearnError::unless_shape("columns of an answer", out.len(), self.outputs())?;
        LearnError::unless_shape("members of a state", state.members.len(), self.members())?;
        LearnError::unless_shape("sums of a state", sums, self.sizes.row_len())?;
        LearnError::unless_finite("inputs", 0, input)?;
        self.advance(state, input, out);
        Ok(())
    }

    fn advance(&self, state: &mut NetworkState, input: &[f64], out: &mut [f64]) {
        let NetworkState { history, members, answer } = state;
        let standardised = input.iter().enumerate().map(|(i, &x)| self.inputs.apply(i, x) as f32);
        let inputs = history.push(standardised);
        let advance = self.sizes.kind.advance();
        out.fill(0.0);
        for (weights, member) in self.members.iter().zip(members) {
            // Weights that no training has touched must not act.
            if !self.recurrent {
                member.reset();
            }
            advance(weights, member, inputs, answer);
            out.iter_mut().zip(answer.iter()).for_each(|(sum, y)| *sum += f64::from(*y));
        }
        let share = 1.0 / self.members.len() as f64;
        out.iter_mut().enumerate().for_each(|(o, out)| *out = self.outputs.invert(o, *out * share));
    }

    /// Outputs row by row, as [`Network::step`] gives them when the state is reset at the rows in
    /// `sequences` (increasing; the first row always begins a sequence).
    ///
    /// # Errors
    /// Another width, numbers that are not finite, start rows out of order.
    pub fn predict_rows(&self, inputs: &Rows, sequences: &[usize]) -> Result<Rows, LearnError> {
        LearnError::unless_shape("columns of a query", inputs.width(), self.inputs())?;
        check_finite("inputs", inputs)?;
        super::windows::check_sequences(sequences, inputs.len())?;
        let mut state = self.state();
        let mut answer = vec![0.0; self.outputs()];
        let mut out = Rows::new(self.outputs());
        let mut starts = sequences.iter().copied().peekable();
        for (index, row) in inputs.iter().enumerate() {
            if starts.next_if_eq(&index).is_some() {
                state.reset();
            }
            self.advance(&mut state, row, &mut answer);
            out.push(&answer);
        }
        Ok(out)
    }
}

/// Stored form of a network. Text that was written before there were kinds lacks the fields with a
/// default.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredNetwork {
    inputs: Standardiser,
    hidden: usize,
    outputs: Standardiser,
    recurrent: bool,
    /// The members' weights, one after the other.
    #[serde(with = "exact::f32s")]
    weights: Vec<f32>,
    #[serde(default)]
    kind: NetworkKind,
    #[serde(default = "one")]
    history: usize,
}

fn one() -> usize {
    1
}

impl From<Network> for StoredNetwork {
    fn from(network: Network) -> Self {
        StoredNetwork {
            hidden: network.sizes.hidden,
            inputs: network.inputs,
            outputs: network.outputs,
            recurrent: network.recurrent,
            weights: network.members.into_iter().flat_map(|weights| weights.values).collect(),
            kind: network.sizes.kind,
            history: network.history,
        }
    }
}

impl TryFrom<StoredNetwork> for Network {
    type Error = LearnError;

    fn try_from(stored: StoredNetwork) -> Result<Network, LearnError> {
        let (inputs, outputs) = (stored.inputs.width() * stored.history, stored.outputs.width());
        let sizes = Sizes { kind: stored.kind, inputs, hidden: stored.hidden, outputs };
        let members = stored.weights.chunks_exact(sizes.len().max(1));
        if stored.weights.is_empty() || !members.remainder().is_empty() {
            let (what, found) = ("stored weights", stored.weights.len());
            return Err(LearnError::Shape { what, found, expected: sizes.len() });
        }
        Ok(Network {
            members: members.map(|values| Weights { sizes, values: values.to_vec() }).collect(),
            sizes,
            history: stored.history,
            inputs: stored.inputs,
            outputs: stored.outputs,
            recurrent: stored.recurrent,
        })
    }
}
