//! Policies from outside: an ONNX file, a class of Python, or a program in any language. A spec names
//! them in `policies`: `mine: {onnx: {file: mine.onnx}}`. They see what every policy sees and are held
//! to the same limits.

mod answer;
mod controller;
mod onnx_policy;
mod process;
mod python;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use answer::answer_requests;
pub use controller::{OutsideDecider, OutsideDecision, OutsideView};
pub use onnx_policy::{OnnxInput, OnnxInputs, OnnxOptions, OnnxOutput, OnnxWindow};
pub use process::{ProcessOptions, ProgramOptions};
pub use python::{PythonHost, PythonOptions, provide_python};

use super::{PolicyEntry, PolicyOptions};
use crate::base::{BadOption, Policy};
use controller::OutsideController;
use process::{Hello, ProcessDecider};

/// A user-defined policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum OutsidePolicy {
    /// A network in an ONNX file.
    Onnx(OnnxOptions),
    /// A class in a Python file.
    Python(PythonOptions),
    /// A program in any language that answers requests in lines of JSON.
    Program(ProgramOptions),
}

/// User-defined policies by name.
pub type OutsidePolicies = BTreeMap<String, OutsidePolicy>;

/// Keys of [`OutsidePolicy`].
pub const OUTSIDE_KINDS: [&str; 3] = ["onnx", "python", "program"];

/// What the registry would say of a policy from outside.
static OPEN_OR_CLOSED: PolicyEntry = PolicyEntry::PLAIN;
static CLOSED_ONLY: PolicyEntry = PolicyEntry { closed_loop_only: true, ..PolicyEntry::PLAIN };

impl OutsidePolicy {
    /// Its entry; the name in it is not its own.
    pub fn entry(&self) -> &'static PolicyEntry {
        let closed_only = match self {
            OutsidePolicy::Onnx(options) => {
                options.closed_loop_only || options.output == OnnxOutput::Changes
            }
            OutsidePolicy::Python(options) => options.closed_loop_only,
            OutsidePolicy::Program(options) => options.closed_loop_only,
        };
        if closed_only { &CLOSED_ONLY } else { &OPEN_OR_CLOSED }
    }

    /// The file that holds it.
    pub fn file(&self) -> &Path {
        match self {
            OutsidePolicy::Onnx(options) => &options.file,
            OutsidePolicy::Python(options) => &options.file,
            OutsidePolicy::Program(options) => &options.file,
        }
    }

    /// The same with another file.
    #[must_use]
    pub fn with_file(mut self, file: PathBuf) -> OutsidePolicy {
        match &mut self {
            OutsidePolicy::Onnx(options) => options.file = file,
            OutsidePolicy::Python(options) => options.file = file,
            OutsidePolicy::Program(options) => options.file = file,
        }
        self
    }

    /// Takes over what its file says of it, for a robot with so many tendons.
    pub fn read_attributes(&mut self, tendons: usize, process: &ProcessOptions) {
        match self {
            OutsidePolicy::Onnx(_) | OutsidePolicy::Program(_) => {}
            OutsidePolicy::Python(options) => options.read_attributes(tendons, process),
        }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        match self {
            OutsidePolicy::Onnx(options) => options.check(),
            OutsidePolicy::Python(options) => options.check(),
            OutsidePolicy::Program(options) => {
                BadOption::unless_positive("settled_m", options.settled_m)
            }
        }
    }

    /// Most samples that it takes of the robot before its trials.
    pub fn samples(&self) -> usize {
        match self {
            OutsidePolicy::Onnx(_) => 0,
            OutsidePolicy::Python(options) => options.samples,
            OutsidePolicy::Program(options) => options.samples,
        }
    }

    /// Checks the bytes of its file for a robot with so many tendons.
    ///
    /// # Errors
    /// What was found and what was expected, as the end of a sentence.
    pub fn check_content(
        &self,
        content: &[u8],
        tendons: usize,
        process: &ProcessOptions,
    ) -> Result<(), (String, String)> {
        match self {
            OutsidePolicy::Onnx(options) => onnx_policy::read(options, content, tendons).map(drop),
            OutsidePolicy::Python(options) => options.check_content(content, tendons, process),
            OutsidePolicy::Program(options) => {
                let started = program(options, tendons, process).start();
                let expected = "a program that answers as docs/reference/protocols.md describes";
                started.map(drop).map_err(|error| (error.to_string(), expected.to_owned()))
            }
        }
    }

    /// Builds it from the bytes of its file, for a robot with so many tendons.
    ///
    /// # Errors
    /// What is not as it should be, in words.
    pub fn build(
        &self,
        content: &[u8],
        tendons: usize,
        options: &PolicyOptions,
    ) -> Result<Box<dyn Policy>, String> {
        let process = &options.process;
        let (decider, settled_m): (Box<dyn OutsideDecider>, f64) = match self {
            OutsidePolicy::Onnx(onnx) if process.confined => {
                let command = process.own_command(self, &onnx.file);
                let hello = Hello { tendons, samples: 0 };
                (Box::new(ProcessDecider::new(command, process, hello)), onnx.settled_m)
            }
            OutsidePolicy::Onnx(onnx) => {
                let policy = onnx_policy::OnnxDecider::new(onnx, content, tendons);
                let words = |(found, expected)| {
                    format!("{}: found {found}, expected {expected}", onnx.file.display())
                };
                (Box::new(policy.map_err(words)?), onnx.settled_m)
            }
            OutsidePolicy::Python(python) => (python.decider(tendons, process)?, python.settled_m),
            OutsidePolicy::Program(options) => {
                (Box::new(program(options, tendons, process)), options.settled_m)
            }
        };
        Ok(Box::new(OutsideController::new(decider, settled_m, options)))
    }
}

fn program(options: &ProgramOptions, tendons: usize, process: &ProcessOptions) -> ProcessDecider {
    let hello = Hello { tendons, samples: options.samples };
    ProcessDecider::new(process.program_command(options), process, hello)
}
