//! Recurrent operators (<https://onnx.ai/onnx/operators/>: RNN, GRU, LSTM), forward in time, for one
//! sequence at a time.

use super::OnnxError;
use super::graph::OnnxNode;
use super::tensor::{Tensor, shape};

/// Names of the recurrent operators.
pub(super) const RECURRENT: [&str; 3] = ["GRU", "LSTM", "RNN"];

/// What a recurrent operator remembers: its hidden state and, of an LSTM, that of its cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct RecurrentState {
    hidden: Vec<f64>,
    cells: Vec<f64>,
}

/// The outputs Y, Y_h and (LSTM) Y_c, and the state after the last row. `kept` is the state to begin
/// with in place of the inputs `initial_h` and `initial_c`.
pub(super) fn apply(
    node: &OnnxNode,
    inputs: &[Option<&Tensor>],
    kept: Option<&RecurrentState>,
) -> Result<(Vec<Tensor>, RecurrentState), OnnxError> {
    let layer = RecurrentLayer::new(node, inputs)?;
    let rows = at(node, inputs, 0)?;
    let [steps, 1, width] = rows.dims[..] else {
        let found =
            format!("found an input of shape {:?}, expected (steps, 1, numbers)", rows.dims);
        return Err(shape(&node.operator, found));
    };
    if width != layer.inputs {
        let found = format!("found {width} numbers per row, expected {}", layer.inputs);
        return Err(shape(&node.operator, found));
    }
    let initial = |place: usize| {
        let given = inputs.get(place).copied().flatten().map(|state| state.values.clone());
        given.unwrap_or_else(|| vec![0.0; layer.hidden])
    };
    let mut state = match kept {
        Some(state) => state.clone(),
        None => RecurrentState { hidden: initial(5), cells: initial(6) },
    };
    if state.hidden.len() != layer.hidden || state.cells.len() != layer.hidden {
        return Err(shape(
            &node.operator,
            format!("a state of other than {} numbers", layer.hidden),
        ));
    }
    let mut all = Vec::with_capacity(steps * layer.hidden);
    for row in rows.values.chunks_exact(width.max(1)) {
        layer.step(row, &mut state);
        all.extend_from_slice(&state.hidden);
    }
    let array =
        |dims: &[usize], values: &[f64]| Tensor { dims: dims.to_vec(), values: values.to_vec() };
    let outputs = vec![
        array(&[steps, 1, 1, layer.hidden], &all),
        array(&[1, 1, layer.hidden], &state.hidden),
        array(&[1, 1, layer.hidden], &state.cells),
    ];
    Ok((outputs, state))
}

fn at<'a>(
    node: &OnnxNode,
    inputs: &[Option<&'a Tensor>],
    place: usize,
) -> Result<&'a Tensor, OnnxError> {
    let missing = || shape(&node.operator, format!("found {} inputs, expected more", inputs.len()));
    inputs.get(place).copied().flatten().ok_or_else(missing)
}

/// A function of one number.
type Activation = fn(f64) -> f64;

/// A kind of recurrent layer.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cell {
    Elman,
    Gru,
    Lstm,
}

/// The weights of a layer with their functions.
struct RecurrentLayer<'a> {
    cell: Cell,
    inputs: usize,
    hidden: usize,
    /// W, (gates × hidden) rows of `inputs` numbers.
    weights: &'a [f64],
    /// R, as many rows of `hidden` numbers.
    recurrent: &'a [f64],
    /// Of W, then of R; empty for none.
    biases: &'a [f64],
    /// P of an LSTM, for the gates i, o and f; empty for none.
    peepholes: &'a [f64],
    functions: [Activation; 3],
    linear_before_reset: bool,
}

impl<'a> RecurrentLayer<'a> {
    fn new(
        node: &OnnxNode,
        inputs: &[Option<&'a Tensor>],
    ) -> Result<RecurrentLayer<'a>, OnnxError> {
        let wrong = |what: String| shape(&node.operator, what);
        let direction = node.texts("direction");
        if direction.first().is_some_and(|direction| *direction != "forward") {
            return Err(wrong(format!("found the direction {direction:?}, expected forward")));
        }
        if node.integer("layout", 0) != 0 || node.attributes.contains_key("clip") {
            return Err(wrong("found `layout` or `clip`, which are not supported".to_owned()));
        }
        let (cell, gates) = match node.operator.as_str() {
            "GRU" => (Cell::Gru, 3),
            "LSTM" => (Cell::Lstm, 4),
            _ => (Cell::Elman, 1),
        };
        let (weights, recurrent) = (at(node, inputs, 1)?, at(node, inputs, 2)?);
        let ([1, rows, width], [1, recurrent_rows, hidden]) =
            (&weights.dims[..], &recurrent.dims[..])
        else {
            let found =
                format!("found weights of shapes {:?} and {:?}", weights.dims, recurrent.dims);
            return Err(wrong(found));
        };
        let optional = |place: usize| {
            inputs.get(place).copied().flatten().map_or(&[][..], |tensor| &tensor.values)
        };
        let layer = RecurrentLayer {
            cell,
            inputs: *width,
            hidden: *hidden,
            weights: &weights.values,
            recurrent: &recurrent.values,
            biases: optional(3),
            peepholes: optional(7),
            functions: functions(node, cell)?,
            linear_before_reset: node.integer("linear_before_reset", 0) != 0,
        };
        let has_size = |values: &[f64], size: usize| values.is_empty() || values.len() == size;
        let good = *rows == gates * hidden
            && recurrent_rows == rows
            && has_size(layer.biases, 2 * rows)
            && has_size(layer.peepholes, 3 * hidden);
        if good { Ok(layer) } else { Err(wrong("weights of sizes that do not fit".to_owned())) }
    }

    /// The sum of a gate's unit: (W x + b_W, R h + b_R).
    fn sums(&self, gate: usize, unit: usize, row: &[f64], hidden: &[f64]) -> (f64, f64) {
        let line = gate * self.hidden + unit;
        let dot = |values: &[f64], with: &[f64]| {
            values.iter().zip(with).map(|(weight, value)| weight * value).sum::<f64>()
        };
        let bias = |place: usize| self.biases.get(place).copied().unwrap_or(0.0);
        let rows = self.weights.len() / self.inputs.max(1);
        (
            dot(&self.weights[line * self.inputs..][..self.inputs], row) + bias(line),
            dot(&self.recurrent[line * self.hidden..][..self.hidden], hidden) + bias(rows + line),
        )
    }

    fn step(&self, row: &[f64], state: &mut RecurrentState) {
        let before = std::mem::take(&mut state.hidden);
        state.hidden = match self.cell {
            Cell::Elman => {
                let [f, ..] = self.functions;
                let unit = |unit| {
                    let (input, memory) = self.sums(0, unit, row, &before);
                    f(input + memory)
                };
                (0..self.hidden).map(unit).collect()
            }
            Cell::Gru => self.gru(row, &before),
            Cell::Lstm => self.lstm(row, &before, &mut state.cells),
        };
    }

    /// The gates are z, r and h.
    fn gru(&self, row: &[f64], before: &[f64]) -> Vec<f64> {
        let [f, g, _] = self.functions;
        let gate = |gate: usize, unit: usize| {
            let (input, memory) = self.sums(gate, unit, row, before);
            f(input + memory)
        };
        let reset: Vec<f64> = (0..self.hidden).map(|unit| gate(1, unit)).collect();
        let held: Vec<f64> = reset.iter().zip(before).map(|(reset, h)| reset * h).collect();
        let unit = |unit: usize| {
            let candidate = if self.linear_before_reset {
                let (input, memory) = self.sums(2, unit, row, before);
                g(input + reset[unit] * memory)
            } else {
                let (input, memory) = self.sums(2, unit, row, &held);
                g(input + memory)
            };
            let update = gate(0, unit);
            (1.0 - update) * candidate + update * before[unit]
        };
        (0..self.hidden).map(unit).collect()
    }

    /// The gates are i, o, f and c.
    fn lstm(&self, row: &[f64], before: &[f64], cells: &mut [f64]) -> Vec<f64> {
        let [f, g, h] = self.functions;
        let sum = |gate: usize, unit: usize| {
            let (input, memory) = self.sums(gate, unit, row, before);
            input + memory
        };
        let peephole = |gate: usize, unit: usize| {
            self.peepholes.get(gate * self.hidden + unit).copied().unwrap_or(0.0)
        };
        let mut hidden = Vec::with_capacity(self.hidden);
        for (unit, cell) in cells.iter_mut().enumerate() {
            let input = f(sum(0, unit) + peephole(0, unit) * *cell);
            let forget = f(sum(2, unit) + peephole(2, unit) * *cell);
            *cell = forget * *cell + input * g(sum(3, unit));
            let output = f(sum(1, unit) + peephole(1, unit) * *cell);
            hidden.push(output * h(*cell));
        }
        hidden
    }
}

/// The functions f, g and h of the standard, as `activations` names them.
fn functions(node: &OnnxNode, cell: Cell) -> Result<[Activation; 3], OnnxError> {
    let sigmoid: Activation = |value| 1.0 / (1.0 + (-value).exp());
    let tanh: Activation = f64::tanh;
    let mut functions = if cell == Cell::Elman { [tanh; 3] } else { [sigmoid, tanh, tanh] };
    for (function, name) in functions.iter_mut().zip(node.texts("activations")) {
        *function = match name.to_lowercase().as_str() {
            "sigmoid" => sigmoid,
            "tanh" => f64::tanh,
            "relu" => |value| value.max(0.0),
            other => {
                let found = format!("found the activation {other}, expected Sigmoid, Tanh or Relu");
                return Err(shape(&node.operator, found));
            }
        };
    }
    Ok(functions)
}
