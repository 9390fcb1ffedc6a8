//! Weights of a network and their memory layout.

use rand::RngExt;

use super::kinds::NetworkKind;
use crate::base::Seed;
use crate::learn::simd::Real;

/// Units are computed this many at a time, so their number is rounded up; the extra ones stay at
/// zero.
pub(super) const TILE: usize = 8;

/// Kind and sizes of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sizes {
    pub(super) kind: NetworkKind,
    /// Columns of inputs times the rows of history.
    pub(super) inputs: usize,
    pub(super) hidden: usize,
    pub(super) outputs: usize,
}

impl Sizes {
    /// Hidden units with padding.
    pub(super) fn units(&self) -> usize {
        self.hidden.next_multiple_of(TILE)
    }

    /// Outputs with padding.
    pub(super) fn ports(&self) -> usize {
        self.outputs.next_multiple_of(TILE)
    }

    /// Sums of all units: the width of a row of the hidden layer, block after block.
    pub(super) fn row_len(&self) -> usize {
        self.kind.weighted_sums().len() * self.units()
    }

    /// Numbers of the hidden layer: `inputs` rows of input weights, `hidden` rows of recurrent
    /// weights and a row of biases, each `sums` wide. Weights of what a block does not see stay at
    /// zero.
    pub(super) fn hidden_len(&self) -> usize {
        (self.inputs + self.hidden + 1) * self.row_len()
    }

    /// Numbers of both layers; the output layer has `hidden` rows of weights and a row of biases,
    /// `ports` wide.
    pub(super) fn len(&self) -> usize {
        self.hidden_len() + (self.hidden + 1) * self.ports()
    }

    /// Whether row `row` of the hidden layer is seen by block `block`.
    fn connects(&self, row: usize, block: usize) -> bool {
        let block = self.kind.weighted_sums()[block];
        if row < self.inputs {
            block.inputs
        } else {
            row == self.inputs + self.hidden || block.state
        }
    }
}

/// Weights of the hidden and of the linear output layer `y = W_o h + c`, or a gradient with respect
/// to them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Weights<T> {
    pub(super) sizes: Sizes,
    pub(super) values: Vec<T>,
}

impl<T: Real> Weights<T> {
    pub(super) fn zeros(sizes: Sizes) -> Self {
        Weights { sizes, values: vec![T::default(); sizes.len()] }
    }

    /// Uniform in ±√(1/hidden) as PyTorch's `nn.RNN`, `nn.GRU` and `nn.LSTM`, drawn from the seed.
    pub(super) fn random(sizes: Sizes, seed: Seed) -> Self {
        let mut weights = Self::zeros(sizes);
        let mut rng = seed.rng();
        let reach = (1.0 / sizes.hidden as f64).sqrt();
        let (hidden, output) = weights.layers_mut();
        for (row, values) in hidden.chunks_exact_mut(sizes.row_len()).enumerate() {
            for (block, values) in values.chunks_exact_mut(sizes.units()).enumerate() {
                if sizes.connects(row, block) {
                    values[..sizes.hidden]
                        .iter_mut()
                        .for_each(|w| *w = T::of(rng.random_range(-reach..reach)));
                }
            }
        }
        for row in output.chunks_exact_mut(sizes.ports()) {
            row[..sizes.outputs]
                .iter_mut()
                .for_each(|w| *w = T::of(rng.random_range(-reach..reach)));
        }
        weights
    }

    /// The hidden layer's input weights, recurrent weights and biases.
    pub(super) fn hidden(&self) -> [&[T]; 3] {
        let (from_inputs, state_and_bias) = self.values[..self.sizes.hidden_len()]
            .split_at(self.sizes.inputs * self.sizes.row_len());
        let (from_state, bias) = state_and_bias.split_at(self.sizes.hidden * self.sizes.row_len());
        [from_inputs, from_state, bias]
    }

    /// Output layer: rows of weights, bias.
    pub(super) fn output(&self) -> &[T] {
        &self.values[self.sizes.hidden_len()..]
    }

    /// Hidden layer and output layer.
    pub(super) fn layers_mut(&mut self) -> (&mut [T], &mut [T]) {
        let split = self.sizes.hidden_len();
        self.values.split_at_mut(split)
    }
}
