//! Networks from ONNX files (<https://onnx.ai/onnx/repo-docs/IR.html>), with memory or without:
//! read, checked and evaluated in double precision, in the same order on every processor, so that a
//! run has the same bytes everywhere. Operators are those of the standard, restricted to what
//! policies are made of ([`OPERATORS`]).

mod graph;
mod network;
mod operators;
mod protobuf;
mod recurrent;
mod shapes;
mod tensor;

pub use network::{OnnxMemory, OnnxNetwork};
pub use operators::OPERATORS;

/// Why a file is no network that can be evaluated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OnnxError {
    /// The bytes are not those of a model.
    #[error("not an ONNX model: {0}")]
    NotOnnx(&'static str),
    /// An operator that is not known here.
    #[error(
        "operator {0}, which is not one of {list} (export the network with these, or run it from a \
         Python class: `python: {{file, class}}`)",
        list = OPERATORS.join(", ")
    )]
    Operator(String),
    /// A type of number that is not known here.
    #[error("numbers of ONNX type {0}, expected float or double (and int64 for shapes)")]
    Numbers(i64),
    /// Not as many inputs as outputs.
    #[error(
        "{inputs} inputs and {outputs} outputs, expected one of each, and further ones in pairs: the \
         states of a network with memory"
    )]
    Ends {
        /// Number of inputs.
        inputs: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// Shapes that do not fit each other.
    #[error("{operator}: {what}")]
    Shape {
        /// The operator.
        operator: String,
        /// What does not fit.
        what: String,
    },
    /// A value that no operator has made.
    #[error("the value `{0}`, which no preceding operator computes")]
    Missing(String),
}
