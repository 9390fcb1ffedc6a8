//! The trained Elman network.

use serde::{Deserialize, Serialize};

use super::weights::{Sizes, Weights};
use crate::base::Rows;
use crate::learn::simd::Real;
use crate::learn::standardise::check_finite;
use crate::learn::{LearnError, Standardiser, exact};
use crate::math::vectorised;

/// An Elman network (one hidden layer of tanh units that see their own previous values) with a linear output layer:
/// paper IV-A, eqs 17 and 21. Inputs and outputs are in their own units; standardising is inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StoredNetwork", into = "StoredNetwork")]
pub struct Elman {
    pub(super) weights: Weights<f32>,
    pub(super) inputs: Standardiser,
    pub(super) outputs: Standardiser,
    /// False for a network trained on single rows: its recurrent weights are not used.
    pub(super) recurrent: bool,
}

/// The hidden units' values between two steps; all zero after a reset.
#[derive(Clone, Debug, PartialEq)]
pub struct ElmanState {
    hidden: Vec<f32>,
    next: Vec<f32>,
}

impl ElmanState {
    /// Resets to the zero state.
    pub fn reset(&mut self) {
        self.hidden.fill(0.0);
    }
}

impl Elman {
    /// The zero state.
    pub fn state(&self) -> ElmanState {
        let units = self.weights.sizes.units();
        ElmanState { hidden: vec![0.0; units], next: vec![0.0; units] }
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.weights.sizes.inputs
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.weights.sizes.outputs
    }

    /// Hidden units.
    pub fn hidden(&self) -> usize {
        self.weights.sizes.hidden
    }

    /// One step: reads `input`, moves `state` on and writes the outputs, all in their own units.
    ///
    /// # Errors
    /// Wrong widths, or an input that is not finite (the state is then left as it was).
    pub fn step(&self, state: &mut ElmanState, input: &[f64], out: &mut [f64]) -> Result<(), LearnError> {
        let sizes = self.weights.sizes;
        let widths = [
            ("columns of a query", input.len(), sizes.inputs),
            ("columns of an answer", out.len(), sizes.outputs),
            ("hidden units of a state", state.hidden.len(), sizes.units()),
        ];
        for (what, found, expected) in widths {
            if found != expected {
                return Err(LearnError::Shape { what, found, expected });
            }
        }
        if let Some(column) = input.iter().position(|x| !x.is_finite()) {
            return Err(LearnError::NotFinite { table: "inputs", row: 0, column, value: input[column] });
        }
        self.advance(state, input, out);
        Ok(())
    }

    fn advance(&self, state: &mut ElmanState, input: &[f64], out: &mut [f64]) {
        let Sizes { inputs, hidden, .. } = self.weights.sizes;
        let (units, ports) = (self.weights.sizes.units(), self.weights.sizes.ports());
        vectorised(
            #[inline(always)]
            || {
                let (from_inputs, rest) = self.weights.hidden().split_at(inputs * units);
                let (from_state, bias) = rest.split_at(hidden * units);
                let next = &mut state.next[..];
                next.copy_from_slice(bias);
                for (i, row) in from_inputs.chunks_exact(units).enumerate() {
                    add_scaled(next, row, self.inputs.apply(i, input[i]) as f32);
                }
                if self.recurrent {
                    for (row, &h) in from_state.chunks_exact(units).zip(&state.hidden) {
                        add_scaled(next, row, h);
                    }
                }
                next.iter_mut().for_each(|h| *h = h.tanh_fast());
                let (from_hidden, bias) = self.weights.output().split_at(hidden * ports);
                for (o, out) in out.iter_mut().enumerate() {
                    let terms = from_hidden.chunks_exact(ports).zip(next.iter());
                    let y = terms.fold(bias[o], |sum, (row, &h)| row[o].mul_add(h, sum));
                    *out = self.outputs.invert(o, f64::from(y));
                }
            },
        );
        std::mem::swap(&mut state.hidden, &mut state.next);
    }

    /// Outputs row by row, as [`Elman::step`] gives them when the state is reset at the rows in `sequences`
    /// (increasing; the first row always begins a sequence).
    ///
    /// # Errors
    /// Another width, numbers that are not finite, start rows out of order.
    pub fn predict_rows(&self, inputs: &Rows, sequences: &[usize]) -> Result<Rows, LearnError> {
        if inputs.width() != self.inputs() {
            let what = "columns of a query";
            return Err(LearnError::Shape { what, found: inputs.width(), expected: self.inputs() });
        }
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

/// `out += scale · row`.
#[inline(always)]
fn add_scaled(out: &mut [f32], row: &[f32], scale: f32) {
    for (out, w) in out.iter_mut().zip(row) {
        *out = w.fma(scale, *out);
    }
}

/// Stored form of a network.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredNetwork {
    inputs: Standardiser,
    hidden: usize,
    outputs: Standardiser,
    recurrent: bool,
    #[serde(with = "exact::f32s")]
    weights: Vec<f32>,
}

impl From<Elman> for StoredNetwork {
    fn from(network: Elman) -> Self {
        StoredNetwork {
            hidden: network.weights.sizes.hidden,
            inputs: network.inputs,
            outputs: network.outputs,
            recurrent: network.recurrent,
            weights: network.weights.values,
        }
    }
}

impl TryFrom<StoredNetwork> for Elman {
    type Error = LearnError;

    fn try_from(stored: StoredNetwork) -> Result<Elman, LearnError> {
        let (inputs, outputs) = (stored.inputs.width(), stored.outputs.width());
        let sizes = Sizes { inputs, hidden: stored.hidden, outputs };
        if stored.weights.len() != sizes.len() {
            let what = "stored weights";
            return Err(LearnError::Shape { what, found: stored.weights.len(), expected: sizes.len() });
        }
        Ok(Elman {
            weights: Weights { sizes, values: stored.weights },
            inputs: stored.inputs,
            outputs: stored.outputs,
            recurrent: stored.recurrent,
        })
    }
}
