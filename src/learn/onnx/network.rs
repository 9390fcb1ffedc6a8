//! A network with one input and one output.

use std::collections::BTreeMap;

use super::OnnxError;
use super::graph::{self, OnnxGraph};
use super::operators::{OPERATORS, apply};
use super::tensor::Tensor;

/// Most numbers in an input; a damaged file may ask for any.
const MAX_INPUTS: usize = 1_000_000;

/// A feed-forward network: one row of numbers in, one row of numbers out.
#[derive(Clone, Debug, PartialEq)]
pub struct OnnxNetwork {
    graph: OnnxGraph,
    inputs: usize,
    /// Whether the input has an axis of samples before that of its numbers.
    sampled: bool,
    outputs: usize,
}

impl OnnxNetwork {
    /// Reads a model file whose input has the shape (n,), (1, n) or (any, n), or one for `inputs`
    /// numbers where the file leaves n open. The network is evaluated once, so that what cannot be
    /// evaluated is refused here.
    ///
    /// # Errors
    /// [`OnnxError`] for other bytes, other operators and shapes that do not fit.
    pub fn read(bytes: &[u8], inputs: usize) -> Result<OnnxNetwork, OnnxError> {
        let graph = graph::read(bytes)?;
        let ([input], [_]) = (graph.inputs.as_slice(), graph.outputs.as_slice()) else {
            return Err(OnnxError::Ends {
                inputs: graph.inputs.len(),
                outputs: graph.outputs.len(),
            });
        };
        if let Some(node) =
            graph.nodes.iter().find(|node| !OPERATORS.contains(&node.operator.as_str()))
        {
            return Err(OnnxError::Operator(node.operator.clone()));
        }
        let sampled = input.dims.len() != 1;
        let inputs = input.dims.last().copied().flatten().unwrap_or(inputs);
        if inputs > MAX_INPUTS {
            return Err(OnnxError::NotOnnx("its input has more than a million numbers"));
        }
        let mut network = OnnxNetwork { graph, inputs, sampled, outputs: 0 };
        // Shapes are seldom stored in full, so one evaluation tells the width of the output.
        network.outputs = network.evaluate(&vec![0.0; inputs])?.len();
        Ok(network)
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// The output for one input.
    ///
    /// # Errors
    /// [`OnnxError::Shape`] for another number of inputs.
    pub fn evaluate(&self, input: &[f64]) -> Result<Vec<f64>, OnnxError> {
        let dims = if self.sampled { vec![1, input.len()] } else { vec![input.len()] };
        let input = Tensor { dims, values: input.to_vec() };
        let mut values: BTreeMap<&str, Tensor> =
            BTreeMap::from([(self.graph.inputs[0].name.as_str(), input)]);
        for node in &self.graph.nodes {
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
            let output = apply(node, &inputs)?;
            if let Some(name) = node.outputs.first() {
                values.insert(name, output);
            }
        }
        let name = &self.graph.outputs[0].name;
        values
            .remove(name.as_str())
            .map(|output| output.values)
            .ok_or_else(|| OnnxError::Missing(name.clone()))
    }
}
