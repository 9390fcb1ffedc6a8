//! Forward pass, loss and back-propagation through time of a batch of windows: Rumelhart, Hinton &
//! Williams 1986; Goodfellow, Bengio & Courville 2016, section 10.2.2.

use super::config::Loss;
use super::kinds::{HiddenUnit, MAX_SAVED, MAX_SUMS, Past};
use super::tiles::{Chunk, ChunkTable, LANES, TableRows, accumulate, each, fma, outer, total};
use super::weights::{Sizes, TILE, Weights};
use crate::learn::simd::Real;
use crate::math::vectorised;

/// Units computed together in registers.
const U: usize = 4;

/// A batch of equally long windows and the room to work on it. Chunk `t · groups + g` of a row
/// holds sixteen windows at time `t`.
pub(super) struct SequenceBatch<T> {
    sizes: Sizes,
    window: usize,
    groups: usize,
    loss: Loss,
    inputs: ChunkTable<T>,
    targets: ChunkTable<T>,
    /// Values of the units; time `t` stands at `t + 1` and the zero state before the window at 0.
    hidden: ChunkTable<T>,
    /// Their memories, likewise, where the kind has them.
    memory: ChunkTable<T>,
    /// What steps kept for the way back: the units' first numbers, then their second, …
    saved: ChunkTable<T>,
    /// ∂loss/∂output.
    errors: ChunkTable<T>,
    /// ∂loss/∂(sums of the units), block after block.
    deltas: ChunkTable<T>,
    /// ∂loss/∂(value and memory before a step), other than by way of the sums.
    carried: [ChunkTable<T>; 2],
    /// Recurrent weights (block after block) and output weights with rows and columns exchanged.
    recurrent_t: Vec<T>,
    output_t: Vec<T>,
    filled: usize,
}

impl<T: Real> SequenceBatch<T> {
    pub(super) fn new(sizes: Sizes, window: usize, batch: usize, loss: Loss) -> Self {
        let (kind, units) = (sizes.kind, sizes.units());
        // Sixteen windows fill the lanes of a chunk; the last group may be partly empty.
        let groups = batch.div_ceil(LANES);
        let width = window * groups;
        let table = |rows: usize, present: bool, width: usize| {
            ChunkTable::zeros(usize::from(present) * rows, width)
        };
        SequenceBatch {
            sizes,
            window,
            groups,
            loss,
            inputs: ChunkTable::zeros(sizes.inputs, width),
            targets: ChunkTable::zeros(sizes.ports(), width),
            hidden: ChunkTable::zeros(units, width + groups),
            memory: table(units, kind.has_memory(), width + groups),
            saved: ChunkTable::zeros(kind.saved() * units, width),
            errors: ChunkTable::zeros(sizes.ports(), width),
            deltas: ChunkTable::zeros(sizes.row_len(), width),
            carried: [table(units, kind.carries(), width), table(units, kind.has_memory(), width)],
            recurrent_t: vec![T::default(); sizes.hidden * sizes.row_len()],
            output_t: vec![T::default(); sizes.outputs * units],
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

    /// Mean squared error (standardised) over the counted rows and its gradient, written to
    /// `gradient`.
    pub(super) fn loss_and_gradient(
        &mut self,
        weights: &Weights<T>,
        gradient: &mut Weights<T>,
    ) -> T {
        self.sizes.kind.work()(self, weights, gradient)
    }

    /// As [`SequenceBatch::loss_and_gradient`], for networks of `C`.
    pub(super) fn work<C: HiddenUnit>(
        &mut self,
        weights: &Weights<T>,
        gradient: &mut Weights<T>,
    ) -> T {
        vectorised!({
            self.forward::<C>(weights);
            let loss = self.compare(weights);
            self.backward::<C>(weights);
            self.collect::<C>(gradient);
            loss
        })
    }

    #[inline(always)]
    fn forward<C: HiddenUnit>(&mut self, weights: &Weights<T>) {
        let Sizes { inputs, hidden, .. } = self.sizes;
        let (units, stride) = (self.sizes.units(), self.sizes.row_len());
        let [from_inputs, from_state, bias] = weights.hidden();
        for at in 0..self.window * self.groups {
            for first in (0..units).step_by(U) {
                let mut sums = [[[T::default(); LANES]; U]; MAX_SUMS];
                for (number, (block, sums)) in C::SUMS.iter().zip(&mut sums).enumerate() {
                    let first = number * units + first;
                    *sums = std::array::from_fn(|u| [bias[first + u]; LANES]);
                    if block.inputs {
                        accumulate(sums, from_inputs, stride, first, &self.inputs, at, inputs);
                    }
                    // The state before the window is zero.
                    if block.state && at >= self.groups {
                        accumulate(sums, from_state, stride, first, &self.hidden, at, hidden);
                    }
                }
                for u in 0..U {
                    self.step::<C>(first + u, at, std::array::from_fn(|block| &sums[block][u]));
                }
            }
        }
    }

    /// One step of sixteen windows of unit `unit`.
    #[inline(always)]
    fn step<C: HiddenUnit>(&mut self, unit: usize, at: usize, sums: [&Chunk<T>; MAX_SUMS]) {
        let zero = [T::default(); LANES];
        let place = unit * self.hidden.width + at;
        let before = if C::CARRIES { self.hidden.chunks[place] } else { zero };
        let memory_before = if C::MEMORY { self.memory.chunks[place] } else { zero };
        let (mut value, mut memory, mut saved) = (zero, zero, [zero; MAX_SAVED]);
        for lane in 0..LANES {
            let sums = std::array::from_fn(|block| sums[block][lane]);
            let after = C::forward(&sums, before[lane], memory_before[lane]);
            (value[lane], memory[lane]) = (after.value, after.memory);
            for k in 0..C::SAVED {
                saved[k][lane] = after.saved[k];
            }
        }
        self.hidden.chunks[place + self.groups] = value;
        if C::MEMORY {
            self.memory.chunks[place + self.groups] = memory;
        }
        for (k, saved) in saved.iter().enumerate().take(C::SAVED) {
            self.saved.chunks[(k * self.sizes.units() + unit) * self.saved.width + at] = *saved;
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
        // The derivative of a mean of squares is 2/n times each residual.
        let (scale, mut loss) = (T::of(2.0 / counted), [T::default(); LANES]);
        for at in 0..self.window * self.groups {
            let group = at % self.groups;
            // Rows that do not count, and empty lanes, have no error and hence no gradient.
            let active = if at / self.groups < first_row {
                0
            } else {
                self.filled.saturating_sub(group * LANES)
            };
            for first in (0..outputs).step_by(U) {
                let mut acc: [Chunk<T>; U] = std::array::from_fn(|u| [bias[first + u]; LANES]);
                if active > 0 {
                    accumulate(
                        &mut acc,
                        from_hidden,
                        ports,
                        first,
                        &self.hidden,
                        at + self.groups,
                        hidden,
                    );
                }
                for (u, acc) in acc.iter().enumerate().take(outputs - first) {
                    let place = (first + u) * self.errors.width + at;
                    let target = self.targets.chunks[place];
                    let residual: Chunk<T> = each(
                        #[inline(always)]
                        |lane| {
                            if lane < active { acc[lane] - target[lane] } else { T::default() }
                        },
                    );
                    self.errors.chunks[place] = each(
                        #[inline(always)]
                        |lane| residual[lane] * scale,
                    );
                    fma(&mut loss, &residual, &residual);
                }
            }
        }
        total(loss) * T::of(1.0 / counted)
    }

    #[inline(always)]
    fn backward<C: HiddenUnit>(&mut self, weights: &Weights<T>) {
        let Sizes { hidden, outputs, .. } = self.sizes;
        let (units, ports, stride) = (self.sizes.units(), self.sizes.ports(), self.sizes.row_len());
        let [_, recurrent, _] = weights.hidden();
        // Products on the way back need columns; once exchanged they are contiguous rows.
        for (block, recurrent_t) in self.recurrent_t.chunks_exact_mut(hidden * units).enumerate() {
            transpose(&recurrent[block * units..], stride, hidden, hidden, recurrent_t, units);
        }
        transpose(weights.output(), ports, hidden, outputs, &mut self.output_t, units);
        for at in (0..self.window * self.groups).rev() {
            // Back in time: what the next step has sent back must be ready.
            let later = at + self.groups;
            for first in (0..units).step_by(U) {
                // ∂loss/∂value by way of the outputs, then by way of the sums of the next step.
                let mut acc = [[T::default(); LANES]; U];
                accumulate(&mut acc, &self.output_t, units, first, &self.errors, at, outputs);
                if later < self.window * self.groups {
                    for (number, _) in C::SUMS.iter().enumerate().filter(|(_, block)| block.state) {
                        let weights = &self.recurrent_t[number * hidden * units..];
                        let from = number * units * self.deltas.width + later;
                        accumulate(&mut acc, weights, units, first, &self.deltas, from, hidden);
                    }
                }
                for (u, acc) in acc.iter().enumerate() {
                    self.step_back::<C>(first + u, at, acc);
                }
            }
        }
    }

    /// The way back of one step of sixteen windows of unit `unit`.
    #[inline(always)]
    fn step_back<C: HiddenUnit>(&mut self, unit: usize, at: usize, d_value: &Chunk<T>) {
        let zero = [T::default(); LANES];
        let (units, later) = (self.sizes.units(), at + self.groups);
        let [hidden, carried] = [&self.hidden, &self.carried[0]].map(|table| unit * table.width);
        let value = self.hidden.chunks[hidden + later];
        let value_before = if C::CARRIES { self.hidden.chunks[hidden + at] } else { zero };
        let memory_before = if C::MEMORY { self.memory.chunks[hidden + at] } else { zero };
        let is_last = later >= self.window * self.groups;
        let from_later = |on: bool, table: &ChunkTable<T>| {
            if on && !is_last { table.chunks[carried + later] } else { zero }
        };
        let carried_value = from_later(C::CARRIES, &self.carried[0]);
        let carried_memory = from_later(C::MEMORY, &self.carried[1]);
        let saved: [Chunk<T>; MAX_SAVED] = std::array::from_fn(
            #[inline(always)]
            |k| {
                if k < C::SAVED {
                    self.saved.chunks[(k * units + unit) * self.saved.width + at]
                } else {
                    zero
                }
            },
        );
        let (mut d_sums, mut d_before, mut d_memory) = ([zero; MAX_SUMS], zero, zero);
        for lane in 0..LANES {
            // A value reaches later ones through the sums and, in a gated unit, directly.
            let d_value =
                if C::CARRIES { d_value[lane] + carried_value[lane] } else { d_value[lane] };
            let back = C::backward(&Past {
                value: value[lane],
                value_before: value_before[lane],
                memory_before: memory_before[lane],
                saved: std::array::from_fn(|k| saved[k][lane]),
                d_value,
                d_memory: carried_memory[lane],
            });
            for (d_sums, back) in d_sums.iter_mut().zip(back.d_sums) {
                d_sums[lane] = back;
            }
            (d_before[lane], d_memory[lane]) = (back.d_value_before, back.d_memory_before);
        }
        for (block, d_sums) in d_sums.iter().enumerate().take(C::SUMS.len()) {
            self.deltas.chunks[(block * units + unit) * self.deltas.width + at] = *d_sums;
        }
        if C::CARRIES {
            self.carried[0].chunks[carried + at] = d_before;
        }
        if C::MEMORY {
            self.carried[1].chunks[carried + at] = d_memory;
        }
    }

    /// Sums the gradient over samples and times.
    #[inline(always)]
    fn collect<C: HiddenUnit>(&self, gradient: &mut Weights<T>) {
        let Sizes { inputs, hidden, outputs, .. } = self.sizes;
        let (units, ports, stride) = (self.sizes.units(), self.sizes.ports(), self.sizes.row_len());
        let width = self.window * self.groups;
        gradient.values.fill(T::default());
        let (hidden_layer, output_layer) = gradient.layers_mut();
        let (from_inputs, state_and_bias) = hidden_layer.split_at_mut(inputs * stride);
        let (from_state, bias) = state_and_bias.split_at_mut(hidden * stride);
        // The state before the first row is zero.
        let later = width - self.groups;
        // The gradient of a weight: its input times ∂loss/∂sum, over all samples and times.
        for (number, block) in C::SUMS.iter().enumerate() {
            let (column, row) = (number * units, number * units * width);
            if block.inputs {
                let out = &mut from_inputs[column..];
                outer(
                    out,
                    stride,
                    rows(&self.inputs, 0, inputs),
                    rows(&self.deltas, row, units),
                    width,
                );
            }
            if block.state && later > 0 {
                let (before, after) = (
                    rows(&self.hidden, self.groups, hidden),
                    rows(&self.deltas, row + self.groups, units),
                );
                outer(&mut from_state[column..], stride, before, after, later);
            }
        }
        sum_rows(&self.deltas, bias);
        let (from_hidden, bias) = output_layer.split_at_mut(hidden * ports);
        let errors = rows(&self.errors, 0, outputs.next_multiple_of(2));
        outer(from_hidden, ports, rows(&self.hidden, self.groups, hidden), errors, width);
        sum_rows(&self.errors, bias);
    }
}

#[inline(always)]
fn rows<T>(table: &ChunkTable<T>, from: usize, count: usize) -> TableRows<'_, T> {
    TableRows { table, from, count }
}

/// `out[c][r] = from[r][c]`.
fn transpose<T: Real>(
    from: &[T],
    stride: usize,
    rows: usize,
    columns: usize,
    out: &mut [T],
    out_stride: usize,
) {
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
mod tests;
