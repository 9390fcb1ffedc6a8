//! The operators (<https://onnx.ai/onnx/operators/>), opset 13 and later.

use super::OnnxError;
use super::graph::OnnxNode;
use super::shapes;
use super::tensor::{Tensor, shape};

/// Operators that are known.
pub const OPERATORS: &[&str] = &[
    "Abs",
    "Add",
    "Cast",
    "Clip",
    "Concat",
    "Constant",
    "ConstantOfShape",
    "Div",
    "Dropout",
    "Elu",
    "Exp",
    "Expand",
    "Flatten",
    "GRU",
    "Gather",
    "Gemm",
    "Identity",
    "LSTM",
    "LeakyRelu",
    "MatMul",
    "Max",
    "Min",
    "Mul",
    "Neg",
    "RNN",
    "Relu",
    "Reshape",
    "Shape",
    "Sigmoid",
    "Slice",
    "Softplus",
    "Split",
    "Sqrt",
    "Squeeze",
    "Sub",
    "Tanh",
    "Transpose",
    "Unsqueeze",
];

/// What an operator without memory makes of its inputs, of which an empty one may be left out.
pub(super) fn apply(node: &OnnxNode, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, OnnxError> {
    match shapes::apply(node, inputs)? {
        Some(outputs) => Ok(outputs),
        None => computed(node, inputs).map(|output| vec![output]),
    }
}

fn computed(node: &OnnxNode, inputs: &[Option<&Tensor>]) -> Result<Tensor, OnnxError> {
    let name = node.operator.as_str();
    let at = |place: usize| {
        let missing = || shape(name, format!("found {} inputs, expected more", inputs.len()));
        inputs.get(place).copied().flatten().ok_or_else(missing)
    };
    if let Some(function) = binary(name) {
        return at(0)?.with(at(1)?, name, function);
    }
    if let Some(function) = elementwise(node) {
        return Ok(at(0)?.map(function));
    }
    match name {
        "Cast" | "Dropout" | "Identity" => at(0).cloned(),
        "Clip" => {
            let bound = |place: usize, key: &str, default: f64| {
                let input = inputs
                    .get(place)
                    .copied()
                    .flatten()
                    .and_then(|tensor| tensor.values.first().copied());
                input.unwrap_or_else(|| node.float(key, default))
            };
            let (low, high) = (bound(1, "min", f64::NEG_INFINITY), bound(2, "max", f64::INFINITY));
            // A value that is not a number stays one.
            Ok(at(0)?.map(|value| {
                if value < low {
                    low
                } else if value > high {
                    high
                } else {
                    value
                }
            }))
        }
        "Constant" => {
            let tensor =
                node.attributes.get("value").and_then(|attribute| attribute.tensor.clone());
            let single = || node.attributes.get("value_float").map(|attribute| attribute.float);
            let scalar = || single().map(|value| Tensor { dims: vec![], values: vec![value] });
            tensor
                .or_else(scalar)
                .ok_or_else(|| shape(name, "found no tensor of numbers".to_owned()))
        }
        "Gemm" => gemm(node, at(0)?, at(1)?, inputs.get(2).copied().flatten()),
        "MatMul" => at(0)?.times(at(1)?, name),
        other => Err(OnnxError::Operator(other.to_owned())),
    }
}

/// Operators of two numbers.
fn binary(name: &str) -> Option<fn(f64, f64) -> f64> {
    match name {
        "Add" => Some(|a, b| a + b),
        "Div" => Some(|a, b| a / b),
        "Max" => Some(|a, b| if b > a || b.is_nan() { b } else { a }),
        "Min" => Some(|a, b| if b < a || b.is_nan() { b } else { a }),
        "Mul" => Some(|a, b| a * b),
        "Sub" => Some(|a, b| a - b),
        _ => None,
    }
}

/// Operators of one number.
fn elementwise(node: &OnnxNode) -> Option<Box<dyn Fn(f64) -> f64>> {
    match node.operator.as_str() {
        "Abs" => Some(Box::new(f64::abs)),
        "Elu" => {
            let alpha = node.float("alpha", 1.0);
            Some(Box::new(move |value| if value < 0.0 { alpha * value.exp_m1() } else { value }))
        }
        "Exp" => Some(Box::new(f64::exp)),
        "LeakyRelu" => {
            let alpha = node.float("alpha", 0.01);
            Some(Box::new(move |value| if value < 0.0 { alpha * value } else { value }))
        }
        "Neg" => Some(Box::new(|value| -value)),
        "Relu" => Some(Box::new(|value| if value < 0.0 { 0.0 } else { value })),
        "Sigmoid" => Some(Box::new(|value| 1.0 / (1.0 + (-value).exp()))),
        // ln(1 + eˣ) without overflow.
        "Softplus" => Some(Box::new(|value| value.max(0.0) + (-value.abs()).exp().ln_1p())),
        "Sqrt" => Some(Box::new(f64::sqrt)),
        "Tanh" => Some(Box::new(f64::tanh)),
        _ => None,
    }
}

/// α A B + β C, with A and B transposed where it says so.
fn gemm(node: &OnnxNode, a: &Tensor, b: &Tensor, c: Option<&Tensor>) -> Result<Tensor, OnnxError> {
    let name = node.operator.as_str();
    let turned = |tensor: &Tensor, key: &str| match node.integer(key, 0) {
        0 => Ok(tensor.clone()),
        _ => tensor.transposed(name),
    };
    let product = turned(a, "transA")?.times(&turned(b, "transB")?, name)?;
    let (alpha, beta) = (node.float("alpha", 1.0), node.float("beta", 1.0));
    match c {
        Some(bias) => product.with(bias, name, |sum, bias| alpha * sum + beta * bias),
        None => Ok(product.map(|sum| alpha * sum)),
    }
}
