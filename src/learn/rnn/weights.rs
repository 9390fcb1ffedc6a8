//! Weights of a network and their memory layout.

use rand::RngExt;

use crate::base::Seed;
use crate::learn::simd::Real;

/// Units are computed this many at a time, so their number is rounded up; the extra ones stay at zero.
pub(super) const TILE: usize = 8;

/// Sizes of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sizes {
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

    /// Numbers of the hidden layer: `inputs` rows of input weights, `hidden` rows of recurrent weights and a row of
    /// biases, each `units` wide.
    pub(super) fn hidden_len(&self) -> usize {
        (self.inputs + self.hidden + 1) * self.units()
    }

    /// Numbers of both layers; the output layer has `hidden` rows of weights and a row of biases, `ports` wide.
    pub(super) fn len(&self) -> usize {
        self.hidden_len() + (self.hidden + 1) * self.ports()
    }
}

/// Weights of `h' = tanh(W_x x + W_h h + b)`, `y = W_o h' + c` (Elman 1990), or a gradient with respect to them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Weights<T> {
    pub(super) sizes: Sizes,
    pub(super) values: Vec<T>,
}

impl<T: Real> Weights<T> {
    pub(super) fn zeros(sizes: Sizes) -> Self {
        Weights { sizes, values: vec![T::default(); sizes.len()] }
    }

    /// Uniform in ±√(1/hidden) as PyTorch's `nn.RNN`, drawn from the seed.
    pub(super) fn random(sizes: Sizes, seed: Seed) -> Self {
        let mut weights = Self::zeros(sizes);
        let mut rng = seed.rng();
        let reach = (1.0 / sizes.hidden as f64).sqrt();
        let (units, ports) = (sizes.units(), sizes.ports());
        let split = sizes.hidden_len();
        let (hidden, output) = weights.values.split_at_mut(split);
        for row in hidden.chunks_exact_mut(units) {
            row[..sizes.hidden].iter_mut().for_each(|w| *w = T::of(rng.random_range(-reach..reach)));
        }
        for row in output.chunks_exact_mut(ports) {
            row[..sizes.outputs].iter_mut().for_each(|w| *w = T::of(rng.random_range(-reach..reach)));
        }
        weights
    }

    /// Hidden layer: rows of input weights, recurrent weights, bias.
    pub(super) fn hidden(&self) -> &[T] {
        &self.values[..self.sizes.hidden_len()]
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
