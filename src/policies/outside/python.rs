//! A policy that is a class of Python. The Python package runs it in its own interpreter; the
//! program alone starts one in a process.

use std::path::PathBuf;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::controller::OutsideDecider;
use super::onnx_policy::settled_m;
use super::process::{Hello, ProcessDecider, ProcessOptions};
use crate::base::{BadOption, PolicyError, is_default};

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
    /// Most samples of the robot that its method `sample` takes before the trials. Such a policy
    /// runs in a process of its own.
    #[serde(default, skip_serializing_if = "is_default")]
    pub samples: usize,
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

    /// The interpreter of the package, where this program is part of it and the policy may share it.
    fn host(&self, process: &ProcessOptions) -> Option<&'static PythonHost> {
        PYTHON.get().filter(|_| !process.confined && self.samples == 0)
    }

    pub(super) fn check_content(
        &self,
        content: &[u8],
        tendons: usize,
        process: &ProcessOptions,
    ) -> Result<(), (String, String)> {
        if std::str::from_utf8(content).is_err() {
            return Err(("bytes that are not UTF-8".to_owned(), "a Python file".to_owned()));
        }
        if let Some(host) = self.host(process) {
            return (host.closed_loop_only)(self).map(drop);
        }
        let started = self.process(tendons, process).and_then(|mut policy| policy.start());
        started
            .map(drop)
            .map_err(|error| (error.to_string(), "a class that can be loaded".to_owned()))
    }

    /// Takes over what the class says of itself. A class that cannot be loaded says nothing;
    /// [`PythonOptions::check_content`] refuses it.
    pub(super) fn read_attributes(&mut self, tendons: usize, process: &ProcessOptions) {
        let closed_loop_only = match self.host(process) {
            Some(host) => (host.closed_loop_only)(self).ok(),
            None => {
                let ready =
                    self.process(tendons, process).and_then(|mut policy| policy.start()).ok();
                ready.and_then(|ready| ready["ready"]["closed_loop_only"].as_bool())
            }
        };
        self.closed_loop_only |= closed_loop_only.unwrap_or(false);
    }

    pub(super) fn decider(
        &self,
        tendons: usize,
        process: &ProcessOptions,
    ) -> Result<Box<dyn OutsideDecider>, String> {
        match self.host(process) {
            Some(host) => (host.make)(self),
            None => {
                Ok(Box::new(self.process(tendons, process).map_err(|error| error.to_string())?))
            }
        }
    }

    fn process(
        &self,
        tendons: usize,
        process: &ProcessOptions,
    ) -> Result<ProcessDecider, PolicyError> {
        let command = process.python_command(&self.file, &self.class_name)?;
        Ok(ProcessDecider::new(command, process, Hello { tendons, samples: self.samples }))
    }
}
