//! The graph of a model file: its operators, constants, input and output (message numbers of
//! `onnx.proto`).

use std::collections::BTreeMap;

use super::OnnxError;
use super::protobuf::{doubles, fields, floats, integers};
use super::tensor::Tensor;

/// An operator with the names of what it reads and makes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct OnnxNode {
    pub(super) operator: String,
    pub(super) inputs: Vec<String>,
    pub(super) outputs: Vec<String>,
    pub(super) attributes: BTreeMap<String, Attribute>,
}

/// A setting of an operator.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Attribute {
    pub(super) float: f64,
    pub(super) integer: i64,
    pub(super) integers: Vec<i64>,
    pub(super) texts: Vec<String>,
    pub(super) tensor: Option<Tensor>,
}

impl OnnxNode {
    /// A setting that is a real number.
    pub(super) fn float(&self, key: &str, default: f64) -> f64 {
        self.attributes.get(key).map_or(default, |attribute| attribute.float)
    }

    /// A setting that is one text or several; none where it is not there.
    pub(super) fn texts(&self, key: &str) -> &[String] {
        self.attributes.get(key).map_or(&[], |attribute| &attribute.texts)
    }

    /// A setting that is a whole number.
    pub(super) fn integer(&self, key: &str, default: i64) -> i64 {
        self.attributes.get(key).map_or(default, |attribute| attribute.integer)
    }
}

/// Name and axes of an input or output; `None` for an axis of any length.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct GraphEnd {
    pub(super) name: String,
    pub(super) dims: Vec<Option<usize>>,
}

/// A graph.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct OnnxGraph {
    pub(super) nodes: Vec<OnnxNode>,
    pub(super) constants: BTreeMap<String, Tensor>,
    pub(super) inputs: Vec<GraphEnd>,
    pub(super) outputs: Vec<GraphEnd>,
}

/// Reads the graph of a model.
pub(super) fn read(bytes: &[u8]) -> Result<OnnxGraph, OnnxError> {
    let model = fields(bytes)?;
    let graph = model
        .iter()
        .find(|(number, _)| *number == 7)
        .ok_or(OnnxError::NotOnnx("it has no graph"))?;
    let mut read = OnnxGraph::default();
    for (number, value) in fields(graph.1.bytes()?)? {
        match number {
            1 => read.nodes.push(node(value.bytes()?)?),
            5 => {
                let (name, tensor) = tensor(value.bytes()?)?;
                read.constants.insert(name, tensor);
            }
            11 => read.inputs.push(end(value.bytes()?)?),
            12 => read.outputs.push(end(value.bytes()?)?),
            _ => {}
        }
    }
    // Older files list constants among the inputs.
    read.inputs.retain(|input| !read.constants.contains_key(&input.name));
    Ok(read)
}

fn node(bytes: &[u8]) -> Result<OnnxNode, OnnxError> {
    let mut read = OnnxNode::default();
    for (number, value) in fields(bytes)? {
        match number {
            1 => read.inputs.push(value.text()?),
            2 => read.outputs.push(value.text()?),
            4 => read.operator = value.text()?,
            5 => {
                let (name, attribute) = attribute(value.bytes()?)?;
                read.attributes.insert(name, attribute);
            }
            _ => {}
        }
    }
    Ok(read)
}

fn attribute(bytes: &[u8]) -> Result<(String, Attribute), OnnxError> {
    let (mut name, mut read) = (String::new(), Attribute::default());
    for (number, value) in fields(bytes)? {
        match number {
            1 => name = value.text()?,
            2 => read.float = value.floats()?.first().copied().unwrap_or_default(),
            3 => read.integer = value.number()?,
            4 | 9 => read.texts.push(value.text()?),
            5 => read.tensor = Some(tensor(value.bytes()?)?.1),
            8 => read.integers.extend(value.numbers()?),
            _ => {}
        }
    }
    Ok((name, read))
}

/// A constant and its name. Type 1 is float, 7 int64, 11 double.
fn tensor(bytes: &[u8]) -> Result<(String, Tensor), OnnxError> {
    let (mut name, mut kind, mut dims, mut values) = (String::new(), 1, Vec::new(), Vec::new());
    let mut raw: Option<&[u8]> = None;
    for (number, value) in fields(bytes)? {
        match number {
            1 => dims.extend(value.numbers()?),
            2 => kind = value.number()?,
            4 => values.extend(value.floats()?),
            7 => values.extend(value.numbers()?.into_iter().map(|number| number as f64)),
            8 => name = value.text()?,
            9 => raw = Some(value.bytes()?),
            10 => values.extend(value.doubles()?),
            13 | 14 => {
                return Err(OnnxError::NotOnnx(
                    "its weights are in another file; export them into the model",
                ));
            }
            _ => {}
        }
    }
    let of_raw = match kind {
        1 => floats,
        7 => integers,
        11 => doubles,
        other => return Err(OnnxError::Numbers(other)),
    };
    if let Some(raw) = raw {
        values = of_raw(raw);
    }
    let dims = dims.into_iter().map(|dim| usize::try_from(dim).unwrap_or(0)).collect();
    let tensor = Tensor::new(dims, values)
        .ok_or(OnnxError::NotOnnx("a constant whose size does not match its shape"))?;
    Ok((name, tensor))
}

fn end(bytes: &[u8]) -> Result<GraphEnd, OnnxError> {
    let mut read = GraphEnd::default();
    for (number, value) in fields(bytes)? {
        match number {
            1 => read.name = value.text()?,
            // ValueInfo.type, Type.tensor_type, Tensor.shape, Shape.dim, Dimension.dim_value.
            2 => {
                for (_, tensor) in
                    fields(value.bytes()?)?.into_iter().filter(|(number, _)| *number == 1)
                {
                    for (_, shape) in
                        fields(tensor.bytes()?)?.into_iter().filter(|(number, _)| *number == 2)
                    {
                        for (_, dim) in
                            fields(shape.bytes()?)?.into_iter().filter(|(number, _)| *number == 1)
                        {
                            let value =
                                fields(dim.bytes()?)?.into_iter().find(|(number, _)| *number == 1);
                            let size = value.map(|(_, size)| size.number()).transpose()?;
                            read.dims.push(
                                size.and_then(|size| usize::try_from(size).ok())
                                    .filter(|size| *size > 0),
                            );
                        }
                    }
                }
            }
            _ => {}
        }
    }
    Ok(read)
}
