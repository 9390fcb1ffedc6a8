//! A policy that is a class of Python. The Python package provides the interpreter; the program
//! alone has none.

use std::path::PathBuf;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::controller::OutsideDecider;
use super::onnx_policy::settled_m;
use crate::base::BadOption;

/// Options of a policy in a file of Python.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PythonOptions {
    /// The file, relative to that of the spec.
    pub file: PathBuf,
    /// Name of the class in it; an instance is made without arguments.
    #[serde(rename = "class")]
    pub class_name: String,
    /// True when it decides by the measured error, so that open loop means nothing to it.
    #[serde(default)]
    pub closed_loop_only: bool,
    /// The policy has settled when the tip is this near to the target, or when it repeats its
    /// command, unless it tells so itself; metres.
    #[serde(default = "settled_m")]
    pub settled_m: f64,
}

/// Makes an instance of a class.
type MakePython = fn(&PythonOptions) -> Result<Box<dyn OutsideDecider>, String>;

static PYTHON: OnceLock<MakePython> = OnceLock::new();

/// Says how instances are made: the Python package calls it when it is imported.
pub fn provide_python(make: MakePython) {
    // The second import of a process provides the same.
    let _ = PYTHON.set(make);
}

impl PythonOptions {
    pub(super) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("settled_m", self.settled_m)
    }

    pub(super) fn check_content(&self, content: &[u8]) -> Result<(), (String, String)> {
        if PYTHON.get().is_none() {
            let expected = "spinebench.run(…) of the Python package (docs/python.md), which runs \
                            policies of Python";
            return Err(("the program without Python".to_owned(), expected.to_owned()));
        }
        match std::str::from_utf8(content) {
            Ok(_) => Ok(()),
            Err(_) => Err(("bytes that are no UTF-8".to_owned(), "a file of Python".to_owned())),
        }
    }

    pub(super) fn decider(&self) -> Result<Box<dyn OutsideDecider>, String> {
        let make = PYTHON
            .get()
            .ok_or("policies of Python run through the Python package (docs/python.md)")?;
        make(self)
    }
}
