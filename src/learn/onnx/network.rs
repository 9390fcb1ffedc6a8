//! A network: one row of numbers in, one row of numbers out, and what it remembers between them.

use std::collections::BTreeMap;

use super::OnnxError;
use super::graph::{self, GraphEnd, OnnxGraph};
use super::operators::{OPERATORS, apply};
use super::recurrent::{self, RECURRENT, RecurrentState};
use super::tensor::Tensor;

/// Most numbers in an input; a damaged file may ask for any.
const MAX_INPUTS: usize = 1_000_000;

/// A network with one input and one output, and with further inputs and outputs in pairs: the states
/// that it is given back.
#[derive(Clone, Debug, PartialEq)]
pub struct OnnxNetwork {
    graph: OnnxGraph,
    /// Shapes of the inputs.
    shapes: Vec<Vec<usize>>,
    outputs: usize,
}

/// What a network remembers: the states of its recurrent operators, or those that it is given back.
/// The default is that of a network that has seen nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OnnxMemory {
    /// By the place of the operator in the graph.
    operators: BTreeMap<usize, RecurrentState>,
    /// In the order of the inputs after the first.
    states: Vec<Tensor>,
}

impl OnnxNetwork {
    /// Reads a model file. Its first input takes `inputs` numbers, in whatever axes; an axis that
    /// the file leaves open has the length that this takes. Each further input is a state, whose
    /// next value is the output in the same place. The network is evaluated once, so that what
    /// cannot be evaluated is refused here.
    ///
    /// # Errors
    /// [`OnnxError`] for other bytes, other operators and shapes that do not fit.
    pub fn read(bytes: &[u8], inputs: usize) -> Result<OnnxNetwork, OnnxError> {
        let graph = graph::read(bytes)?;
        let ends = (graph.inputs.len(), graph.outputs.len());
        if ends.0 == 0 || ends.0 != ends.1 {
            return Err(OnnxError::Ends { inputs: ends.0, outputs: ends.1 });
        }
        if let Some(node) =
            graph.nodes.iter().find(|node| !OPERATORS.contains(&node.operator.as_str()))
        {
            return Err(OnnxError::Operator(node.operator.clone()));
        }
        let states = graph.inputs[1..].iter().map(|input| dims_of(input, 1));
        let shapes: Vec<Vec<usize>> =
            std::iter::once(dims_of(&graph.inputs[0], inputs)).chain(states).collect();
        let size =
            |dims: &Vec<usize>| dims.iter().try_fold(1_usize, |size, &dim| size.checked_mul(dim));
        if shapes.iter().any(|dims| size(dims).is_none_or(|size| size > MAX_INPUTS)) {
            return Err(OnnxError::NotOnnx("an input has more than a million numbers"));
        }
        let mut network = OnnxNetwork { graph, shapes, outputs: 0 };
        // Shapes are seldom stored in full, so one evaluation tells the width of the output.
        network.outputs = network.evaluate(&vec![0.0; network.inputs()])?.len();
        Ok(network)
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.shapes[0].iter().product()
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Whether what it computes depends on the inputs before.
    pub fn has_memory(&self) -> bool {
        self.shapes.len() > 1
            || self.graph.nodes.iter().any(|node| RECURRENT.contains(&node.operator.as_str()))
    }

    /// The output for one input of a network that has seen nothing before.
    ///
    /// # Errors
    /// [`OnnxError::Shape`] for another number of inputs.
    pub fn evaluate(&self, input: &[f64]) -> Result<Vec<f64>, OnnxError> {
        self.evaluate_next(input, &mut OnnxMemory::default())
    }

    /// The output for the input that follows those of `memory`, and adds it to them.
    ///
    /// # Errors
    /// As [`OnnxNetwork::evaluate`].
    pub fn evaluate_next(
        &self,
        input: &[f64],
        memory: &mut OnnxMemory,
    ) -> Result<Vec<f64>, OnnxError> {
        let mut values: BTreeMap<&str, Tensor> = self.ends(input, memory)?;
        for (place, node) in self.graph.nodes.iter().enumerate() {
            let read = |name: &String| {
                // ONNX leaves an optional input out by an empty name.
                if name.is_empty() {
                    return Ok(None);
                }
                let value = values.get(name.as_str()).or_else(|| self.graph.constants.get(name));
                value.map(Some).ok_or_else(|| OnnxError::Missing(name.clone()))
            };
            let inputs: Vec<Option<&Tensor>> =
                node.inputs.iter().map(read).collect::<Result<_, _>>()?;
            let outputs = if RECURRENT.contains(&node.operator.as_str()) {
                // A network that is given its states keeps none within.
                let kept = memory.operators.get(&place).filter(|_| self.shapes.len() == 1);
                let (outputs, state) = recurrent::apply(node, &inputs, kept)?;
                memory.operators.insert(place, state);
                outputs
            } else {
                apply(node, &inputs)?
            };
            values.extend(node.outputs.iter().map(String::as_str).zip(outputs));
        }
        let mut outputs = self.graph.outputs.iter().map(|end| {
            values.remove(end.name.as_str()).ok_or_else(|| OnnxError::Missing(end.name.clone()))
        });
        let output = outputs.next().unwrap_or(Err(OnnxError::Ends { inputs: 1, outputs: 0 }))?;
        memory.states = outputs.collect::<Result<_, _>>()?;
        Ok(output.values)
    }

    /// The values of the inputs by name: the numbers, and the states, at first zero.
    fn ends(
        &self,
        input: &[f64],
        memory: &OnnxMemory,
    ) -> Result<BTreeMap<&str, Tensor>, OnnxError> {
        let mut values = BTreeMap::new();
        for (number, (end, dims)) in self.graph.inputs.iter().zip(&self.shapes).enumerate() {
            let numbers = match number.checked_sub(1) {
                None => input.to_vec(),
                Some(state) => match memory.states.get(state) {
                    Some(state) => state.values.clone(),
                    None => vec![0.0; dims.iter().product()],
                },
            };
            let found = numbers.len();
            let tensor = Tensor::new(dims.clone(), numbers).ok_or_else(|| OnnxError::Shape {
                operator: format!("input `{}`", end.name),
                what: format!("found {found} numbers for the shape {dims:?}"),
            })?;
            values.insert(end.name.as_str(), tensor);
        }
        Ok(values)
    }
}

/// The shape of an input for so many numbers: the last open axis takes what the others leave, the
/// other open ones have length 1.
fn dims_of(end: &GraphEnd, numbers: usize) -> Vec<usize> {
    let known: usize = end.dims.iter().flatten().product();
    let open = end.dims.iter().rposition(Option::is_none);
    let remainder = numbers.checked_div(known).unwrap_or(1).max(1);
    let dim = |(axis, dim): (usize, &Option<usize>)| {
        dim.unwrap_or(if Some(axis) == open { remainder } else { 1 })
    };
    if end.dims.is_empty() { vec![numbers] } else { end.dims.iter().enumerate().map(dim).collect() }
}
