//! Forward pass, loss and back-propagation through time of a batch of windows: Rumelhart, Hinton & Williams 1986;
//! Goodfellow, Bengio & Courville 2016, section 10.2.2.

use super::config::Loss;
use super::tiles::{Chunk, ChunkTable, LANES, accumulate, each, fma, outer, total};
use super::weights::{Sizes, TILE, Weights};
use crate::learn::simd::Real;
use crate::math::vectorised;

/// Units computed together in registers.
const U: usize = 4;

/// A batch of equally long windows and the room to work on it. Chunk `t · groups + g` of a row holds sixteen windows
/// at time `t`.
pub(super) struct SequenceBatch<T> {
    sizes: Sizes,
    window: usize,
    groups: usize,
    loss: Loss,
    inputs: ChunkTable<T>,
    targets: ChunkTable<T>,
    /// Activations; time `t` stands at `t + 1` and the zero state before the window at 0.
    hidden: ChunkTable<T>,
    /// ∂loss/∂output.
    errors: ChunkTable<T>,
    /// ∂loss/∂(argument of tanh).
    deltas: ChunkTable<T>,
    /// Recurrent and output weights with rows and columns exchanged.
    recurrent_t: Vec<T>,
    output_t: Vec<T>,
    filled: usize,
}

impl<T: Real> SequenceBatch<T> {
    pub(super) fn new(sizes: Sizes, window: usize, batch: usize, loss: Loss) -> Self {
        let groups = batch.div_ceil(LANES);
        let width = window * groups;
        SequenceBatch {
            sizes,
            window,
            groups,
            loss,
            inputs: ChunkTable::zeros(sizes.inputs, width),
            targets: ChunkTable::zeros(sizes.ports(), width),
            hidden: ChunkTable::zeros(sizes.units(), width + groups),
            errors: ChunkTable::zeros(sizes.ports(), width),
            deltas: ChunkTable::zeros(sizes.units(), width),
            recurrent_t: vec![T::default(); sizes.hidden * sizes.units()],
            output_t: vec![T::default(); sizes.outputs * sizes.units()],
            filled: 0,
        }
    }

    /// Loads the windows that start at these rows of the standardised tables (row-major).
    pub(super) fn load(&mut self, inputs: &[T], targets: &[T], starts: &[u32]) {
        let Sizes { inputs: i_count, outputs: o_count, .. } = self.sizes;
        self.filled = starts.len();
        for (sample, &start) in starts.iter().enumerate() {
            let (group, lane) = (sample / LANES, sample % LANES);
            for t in 0..self.window {
                let (row, at) = (start as usize + t, t * self.groups + group);
                for (i, &x) in inputs[row * i_count..(row + 1) * i_count].iter().enumerate() {
                    self.inputs.chunks[i * self.inputs.width + at][lane] = x;
                }
                for (o, &y) in targets[row * o_count..(row + 1) * o_count].iter().enumerate() {
                    self.targets.chunks[o * self.targets.width + at][lane] = y;
                }
            }
        }
    }

    /// Mean squared error (standardised) over the counted rows and its gradient, written to `gradient`.
    pub(super) fn loss_and_gradient(&mut self, weights: &Weights<T>, gradient: &mut Weights<T>) -> T {
        vectorised(
            #[inline(always)]
            || {
                self.forward(weights);
                let loss = self.compare(weights);
                self.backward(weights);
                self.collect(gradient);
                loss
            },
        )
    }

    #[inline(always)]
    fn forward(&mut self, weights: &Weights<T>) {
        let Sizes { inputs, hidden, .. } = self.sizes;
        let units = self.sizes.units();
        let (from_inputs, rest) = weights.hidden().split_at(inputs * units);
        let (from_state, bias) = rest.split_at(hidden * units);
        for at in 0..self.window * self.groups {
            for first in (0..units).step_by(U) {
                let mut acc: [Chunk<T>; U] = std::array::from_fn(|u| [bias[first + u]; LANES]);
                accumulate(&mut acc, from_inputs, units, first, &self.inputs, at, inputs);
                if at >= self.groups {
                    accumulate(&mut acc, from_state, units, first, &self.hidden, at, hidden);
                }
                for (u, acc) in acc.iter().enumerate() {
                    let place = (first + u) * self.hidden.width + self.groups + at;
                    self.hidden.chunks[place] = each(
                        #[inline(always)]
                        |lane| acc[lane].tanh_fast(),
                    );
                }
            }
        }
    }

    /// Outputs against targets: fills `errors`, returns the loss.
    #[inline(always)]
    fn compare(&mut self, weights: &Weights<T>) -> T {
        let Sizes { hidden, outputs, .. } = self.sizes;
        let ports = self.sizes.ports();
        let (from_hidden, bias) = weights.output().split_at(hidden * ports);
        let first_row = if self.loss == Loss::LastRow { self.window - 1 } else { 0 };
        let counted = (self.filled * outputs * (self.window - first_row)) as f64;
        let (scale, mut loss) = (T::of(2.0 / counted), [T::default(); LANES]);
        for at in 0..self.window * self.groups {
            let group = at % self.groups;
            let live = if at / self.groups < first_row { 0 } else { self.filled.saturating_sub(group * LANES) };
            for first in (0..outputs).step_by(U) {
                let mut acc: [Chunk<T>; U] = std::array::from_fn(|u| [bias[first + u]; LANES]);
                if live > 0 {
                    accumulate(&mut acc, from_hidden, ports, first, &self.hidden, at + self.groups, hidden);
                }
                for (u, acc) in acc.iter().enumerate().take(outputs - first) {
                    let place = (first + u) * self.errors.width + at;
                    let target = self.targets.chunks[place];
                    let miss: Chunk<T> = each(
                        #[inline(always)]
                        |lane| {
                            if lane < live { acc[lane] - target[lane] } else { T::default() }
                        },
                    );
                    self.errors.chunks[place] = each(
                        #[inline(always)]
                        |lane| miss[lane] * scale,
                    );
                    fma(&mut loss, &miss, &miss);
                }
            }
        }
        total(loss) * T::of(1.0 / counted)
    }

    #[inline(always)]
    fn backward(&mut self, weights: &Weights<T>) {
        let Sizes { inputs, hidden, outputs } = self.sizes;
        let (units, ports) = (self.sizes.units(), self.sizes.ports());
        let recurrent = &weights.hidden()[inputs * units..(inputs + hidden) * units];
        transpose(recurrent, units, hidden, hidden, &mut self.recurrent_t, units);
        transpose(weights.output(), ports, hidden, outputs, &mut self.output_t, units);
        for at in (0..self.window * self.groups).rev() {
            for first in (0..units).step_by(U) {
                let mut acc = [[T::default(); LANES]; U];
                accumulate(&mut acc, &self.output_t, units, first, &self.errors, at, outputs);
                if at + self.groups < self.window * self.groups {
                    accumulate(&mut acc, &self.recurrent_t, units, first, &self.deltas, at + self.groups, hidden);
                }
                for (u, acc) in acc.iter().enumerate() {
                    let h = self.hidden.chunks[(first + u) * self.hidden.width + self.groups + at];
                    let delta = each(
                        #[inline(always)]
                        |lane| acc[lane] * (-h[lane]).fma(h[lane], T::of(1.0)),
                    );
                    self.deltas.chunks[(first + u) * self.deltas.width + at] = delta;
                }
            }
        }
    }

    /// Sums the gradient over samples and times.
    #[inline(always)]
    fn collect(&self, gradient: &mut Weights<T>) {
        let Sizes { inputs, hidden, outputs } = self.sizes;
        let (units, ports) = (self.sizes.units(), self.sizes.ports());
        let width = self.window * self.groups;
        gradient.values.fill(T::default());
        let (hidden_layer, output_layer) = gradient.layers_mut();
        let (from_inputs, rest) = hidden_layer.split_at_mut(inputs * units);
        let (from_state, bias) = rest.split_at_mut(hidden * units);
        outer(from_inputs, units, (&self.inputs, 0, inputs), (&self.deltas, 0, units), width);
        // The state before the first row is zero.
        let later = width - self.groups;
        if later > 0 {
            let after = (&self.deltas, self.groups, units);
            outer(from_state, units, (&self.hidden, self.groups, hidden), after, later);
        }
        sum_rows(&self.deltas, bias);
        let (from_hidden, bias) = output_layer.split_at_mut(hidden * ports);
        let errors = (&self.errors, 0, outputs.next_multiple_of(2));
        outer(from_hidden, ports, (&self.hidden, self.groups, hidden), errors, width);
        sum_rows(&self.errors, bias);
    }
}

/// `out[c][r] = from[r][c]`.
fn transpose<T: Real>(from: &[T], stride: usize, rows: usize, columns: usize, out: &mut [T], out_stride: usize) {
    for r in 0..rows {
        for c in 0..columns {
            out[c * out_stride + r] = from[r * stride + c];
        }
    }
}

#[inline(always)]
fn sum_rows<T: Real>(table: &ChunkTable<T>, out: &mut [T]) {
    for (r, out) in out.iter_mut().enumerate() {
        let mut acc = [T::default(); LANES];
        for chunk in table.row(r) {
            for lane in 0..LANES {
                acc[lane] += chunk[lane];
            }
        }
        *out = total(acc);
    }
}

const _: () = assert!(TILE.is_multiple_of(U));

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    /// Plain recurrences, one sample at a time.
    fn loss_by_definition(w: &Weights<f64>, x: &[f64], y: &[f64], starts: &[u32], window: usize, loss: Loss) -> f64 {
        let Sizes { inputs, hidden, outputs } = w.sizes;
        let (units, ports) = (w.sizes.units(), w.sizes.ports());
        let (mut sum, mut count) = (0.0, 0.0);
        for &start in starts {
            let mut h = vec![0.0; hidden];
            for t in 0..window {
                let row = start as usize + t;
                let next: Vec<f64> = (0..hidden)
                    .map(|u| {
                        let weight = |r: usize| w.hidden()[r * units + u];
                        let mut z = weight(inputs + hidden);
                        z += (0..inputs).map(|i| weight(i) * x[row * inputs + i]).sum::<f64>();
                        z += (0..hidden).map(|k| weight(inputs + k) * h[k]).sum::<f64>();
                        z.tanh()
                    })
                    .collect();
                h = next;
                if loss == Loss::EveryRow || t + 1 == window {
                    for o in 0..outputs {
                        let weight = |r: usize| w.output()[r * ports + o];
                        let out = weight(hidden) + (0..hidden).map(|k| weight(k) * h[k]).sum::<f64>();
                        sum += (out - y[row * outputs + o]).powi(2);
                        count += 1.0;
                    }
                }
            }
        }
        sum / count
    }

    fn samples(count: usize, phase: f64) -> Vec<f64> {
        (0..count).map(|i| (i as f64 * 0.7 + phase).sin()).collect()
    }

    fn check(sizes: Sizes, window: usize, windows: usize, loss: Loss) {
        let rows = windows + window;
        let (x, y) = (samples(rows * sizes.inputs, 0.1), samples(rows * sizes.outputs, 1.3));
        let starts: Vec<u32> = (0..windows as u32).collect();
        let mut weights = Weights::<f64>::random(sizes, Seed(3));
        let mut gradient = Weights::zeros(sizes);
        let mut batch = SequenceBatch::new(sizes, window, windows + 5, loss);
        batch.load(&x, &y, &starts);
        let value = batch.loss_and_gradient(&weights, &mut gradient);
        assert!((value - loss_by_definition(&weights, &x, &y, &starts, window, loss)).abs() < 1e-14);
        let mut used = 0;
        for k in 0..weights.values.len() {
            if weights.values[k] == 0.0 {
                assert_eq!(gradient.values[k], 0.0, "padding must not move");
                continue;
            }
            let (kept, e) = (weights.values[k], 1e-5);
            weights.values[k] = kept + e;
            let above = loss_by_definition(&weights, &x, &y, &starts, window, loss);
            weights.values[k] = kept - e;
            let below = loss_by_definition(&weights, &x, &y, &starts, window, loss);
            weights.values[k] = kept;
            let expected = (above - below) / (2.0 * e);
            assert!((gradient.values[k] - expected).abs() < 1e-9, "{k}: {} {expected}", gradient.values[k]);
            used += usize::from(expected != 0.0);
        }
        assert!(used > sizes.hidden * sizes.inputs);
    }

    #[test]
    fn gradient_is_the_finite_difference() {
        check(Sizes { inputs: 3, hidden: 5, outputs: 2 }, 6, 19, Loss::EveryRow);
        check(Sizes { inputs: 2, hidden: 9, outputs: 3 }, 4, 16, Loss::LastRow);
        check(Sizes { inputs: 7, hidden: 30, outputs: 5 }, 1, 3, Loss::EveryRow);
    }
}
