//! A policy that is a class of Python. The Python package provides the interpreter; the program
//! alone has none.

use std::path::PathBuf;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::controller::OutsideDecider;
use super::onnx_policy::settled_m;
use crate::base::BadOption;

/// Options of a policy in a Python file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PythonOptions {
    /// The file, relative to that of the spec.
    pub file: PathBuf,
    /// Name of the class in it; an instance is made without arguments.
    #[serde(rename = "class")]
    pub class_name: String,
    /// True if it uses the measured error and cannot run in open loop. An attribute
    /// `closed_loop_only` of the class has the same meaning.
    #[serde(default)]
    pub closed_loop_only: bool,
    /// The policy has settled when the tip is within this distance of the target or the command
    /// repeats, unless the policy reports it itself; metres.
    #[serde(default = "settled_m")]
    pub settled_m: f64,
}

/// The interpreter, as far as policies need it.
pub struct PythonHost {
    /// Makes an instance of a class, or says why it cannot.
    pub make: fn(&PythonOptions) -> Result<Box<dyn OutsideDecider>, String>,
    /// Loads a class and gives its `closed_loop_only`; of one that is no policy, what was found and
    /// what was expected.
    pub closed_loop_only: fn(&PythonOptions) -> Result<bool, (String, String)>,
}

static PYTHON: OnceLock<PythonHost> = OnceLock::new();

/// Provides the interpreter: the Python package calls it when it is imported.
pub fn provide_python(host: PythonHost) {
    // The second import of a process provides the same.
    let _ = PYTHON.set(host);
}

impl PythonOptions {
    pub(super) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("settled_m", self.settled_m)
    }

    pub(super) fn check_content(&self, content: &[u8]) -> Result<(), (String, String)> {
        let Some(host) = PYTHON.get() else {
            let expected = "spinebench.run(…) of the Python package (docs/reference/python.md), \
                            which runs Python policies";
            return Err((
                "the program, which does not include Python".to_owned(),
                expected.to_owned(),
            ));
        };
        if std::str::from_utf8(content).is_err() {
            return Err(("bytes that are not UTF-8".to_owned(), "a Python file".to_owned()));
        }
        (host.closed_loop_only)(self).map(drop)
    }

    /// Takes over what the class says of itself. A class that cannot be loaded says nothing;
    /// [`PythonOptions::check_content`] refuses it.
    pub(super) fn read_attributes(&mut self) {
        let closed_loop_only = PYTHON.get().map(|host| (host.closed_loop_only)(self));
        self.closed_loop_only |= closed_loop_only.and_then(Result::ok).unwrap_or(false);
    }

    pub(super) fn decider(&self) -> Result<Box<dyn OutsideDecider>, String> {
        let host = PYTHON
            .get()
            .ok_or("only the Python package runs Python policies (docs/reference/python.md)")?;
        (host.make)(self)
    }
}
