//! A policy in a process of its own, which answers requests in lines of JSON
//! (`docs/reference/protocols.md`).

use std::path::{Path, PathBuf};
use std::process::Command;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::controller::{OutsideDecider, OutsideDecision, OutsideView};
use crate::base::{
    BadOption, Displacements, LinePeer, Observation, PeerError, PolicyError, printable,
};

/// Version of the protocol.
const PROTOCOL: u64 = 1;

/// The program that loads a class of Python and answers for it.
const PYTHON_HOST: &str = include_str!("host.py");

/// Options of a policy that is a program in any language.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProgramOptions {
    /// The program, relative to the file of the spec.
    pub file: PathBuf,
    /// Its arguments.
    #[serde(default)]
    pub arguments: Vec<String>,
    /// True when it decides by the measured error, so that open loop means nothing to it.
    #[serde(default)]
    pub closed_loop_only: bool,
    /// Most samples that it takes of the robot before its trials.
    #[serde(default)]
    pub samples: usize,
    /// The policy has settled when the tip is this near to the target, or when it repeats its
    /// command, unless it answers so itself; metres.
    #[serde(default = "super::onnx_policy::settled_m")]
    pub settled_m: f64,
}

/// How policies with a process of their own run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ProcessOptions {
    /// Run every policy from outside in a process without network, without other files than those
    /// beside its own, and within the limits below (Linux).
    pub confined: bool,
    /// Largest memory of a confined process, MiB.
    pub memory_mib: u64,
    /// Largest processor time of a confined process, seconds.
    pub processor_s: u64,
    /// Time for the first answer: the program starts, loads its libraries and its policy, seconds.
    pub start_s: f64,
    /// Time for each further answer, seconds.
    pub answer_s: f64,
    /// The interpreter of Python.
    pub python: PathBuf,
}

impl Default for ProcessOptions {
    fn default() -> Self {
        ProcessOptions {
            confined: false,
            memory_mib: 2048,
            processor_s: 600,
            start_s: 60.0,
            answer_s: 1.0,
            python: PathBuf::from("python3"),
        }
    }
}

impl ProcessOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_within(
            "memory_mib",
            self.memory_mib,
            256..=1 << 20,
            "256 to 1048576 MiB",
        )?;
        BadOption::unless_within("processor_s", self.processor_s, 1..=86_400, "1 to 86400 s")?;
        BadOption::unless_positive("start_s", self.start_s)?;
        BadOption::unless_positive("answer_s", self.answer_s)
    }

    /// The command for a class of Python in a file.
    ///
    /// # Errors
    /// Why there is no interpreter.
    pub(super) fn python_command(
        &self,
        file: &Path,
        class_name: &str,
    ) -> Result<Vec<String>, PolicyError> {
        // Without `-I`, which ignores PYTHONHASHSEED: the order of sets would differ from run to run.
        let arguments = ["-s", "-B", "-c", PYTHON_HOST].map(str::to_owned).into_iter();
        let arguments = arguments.chain([file.display().to_string(), class_name.to_owned()]);
        if !self.confined {
            let python = std::iter::once(self.python.display().to_string());
            return Ok(python.chain(arguments).collect());
        }
        let [python, prefixes @ ..] = self.interpreter()?;
        let command = std::iter::once(python).chain(arguments).collect();
        Ok(self.within_limits(command, file, &prefixes))
    }

    /// The interpreter itself, not a script that finds it, and the two folders of its library.
    fn interpreter(&self) -> Result<[String; 3], PolicyError> {
        let script = "import sys; print(sys.executable, sys.prefix, sys.base_prefix, sep='\\n')";
        let asked = Command::new(&self.python).args(["-s", "-c", script]).output();
        let python = self.python.display();
        let answer = asked.map_err(|error| PolicyError::Outside(format!("{python}: {error}")))?;
        let text = String::from_utf8_lossy(&answer.stdout).into_owned();
        let lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.try_into().map_err(|_| PolicyError::Outside(format!("{python}: found no Python")))
    }

    /// The command for a program of any language.
    pub(super) fn program_command(&self, options: &ProgramOptions) -> Vec<String> {
        let mut command = vec![options.file.display().to_string()];
        command.extend(options.arguments.iter().cloned());
        self.within_limits(command, &options.file, &[])
    }

    /// The command for a policy that this program answers for.
    pub(super) fn own_command(&self, policy: &impl Serialize, file: &Path) -> Vec<String> {
        let policy = serde_json::to_string(policy).unwrap_or_default();
        let command = [own_program().as_str(), "league", "answer", &policy].map(str::to_owned);
        self.within_limits(command.to_vec(), file, &[])
    }

    /// The same command, which `spinebench league confine` starts where policies are confined. It
    /// may read its folder and `further` ones.
    fn within_limits(&self, command: Vec<String>, file: &Path, further: &[String]) -> Vec<String> {
        if !self.confined {
            return command;
        }
        let folder = file.parent().unwrap_or(Path::new("/")).display().to_string();
        let (memory, processor) = (self.memory_mib.to_string(), self.processor_s.to_string());
        let own = own_program();
        let confine =
            [own.as_str(), "league", "confine", "--memory-mib", &memory, "--cpu-s", &processor];
        let read = std::iter::once(&folder).chain(further).flat_map(|path| ["--read", path]);
        let limits = confine.into_iter().chain(read).chain(["--"]).map(str::to_owned);
        limits.chain(command).collect()
    }
}

/// The file of this program.
fn own_program() -> String {
    std::env::current_exe()
        .map_or_else(|_| "spinebench".to_owned(), |file| file.display().to_string())
}

/// What a policy is told of its robot before anything else.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hello {
    pub(super) tendons: usize,
    pub(super) samples: usize,
}

/// A policy in a process of its own. It is started anew after it failed.
pub(super) struct ProcessDecider {
    command: Vec<String>,
    options: ProcessOptions,
    hello: Hello,
    peer: Option<LinePeer>,
    samples_taken: usize,
}

impl ProcessDecider {
    pub(super) fn new(command: Vec<String>, options: &ProcessOptions, hello: Hello) -> Self {
        ProcessDecider { command, options: options.clone(), hello, peer: None, samples_taken: 0 }
    }

    /// Starts the process; what it answers to the first request.
    pub(super) fn start(&mut self) -> Result<Value, PolicyError> {
        let mut peer = LinePeer::start(&self.command).map_err(failed)?;
        let Hello { tendons, samples } = self.hello;
        // Where it failed, what it has learnt of the robot is lost; there are no samples anew.
        let samples = samples - self.samples_taken;
        let hello = json!({ "hello": { "protocol": PROTOCOL, "tendons": tendons, "samples": samples, "seed": 0 } });
        let answer = self.checked(peer.ask(&hello, self.options.start_s).map_err(failed)?)?;
        self.peer = Some(peer);
        Ok(answer)
    }

    fn ask(&mut self, request: &Value) -> Result<Value, PolicyError> {
        if self.peer.is_none() {
            self.start()?;
        }
        let Some(peer) = &mut self.peer else { return Err(PolicyError::NoMeasurement) };
        match peer.ask(request, self.options.answer_s) {
            Ok(answer) => self.checked(answer),
            Err(error) => {
                // Ends the process: an answer that comes late would be taken for the next one.
                self.peer = None;
                Err(failed(error))
            }
        }
    }

    /// The answer, unless it is an error.
    fn checked(&self, answer: Value) -> Result<Value, PolicyError> {
        let Some(error) = answer.get("error") else { return Ok(answer) };
        let text =
            |key: &str| error.get(key).and_then(Value::as_str).unwrap_or("failed").to_owned();
        let words = printable(&text("message"), 200);
        Err(match text("kind").as_str() {
            "not_finite" => PolicyError::NotFinite("answer of the policy"),
            "out_of_memory" => PolicyError::Outside(format!("out of memory: {words}")),
            _ => PolicyError::Outside(words),
        })
    }

    fn pulls_m(&self, answer: &Value) -> Result<Displacements, PolicyError> {
        let values = answer
            .get("pulls_m")
            .and_then(Value::as_array)
            .ok_or_else(|| PolicyError::Outside("an answer without `pulls_m`".to_owned()))?;
        if values.len() != self.hello.tendons {
            let (found, expected) = (values.len(), self.hello.tendons);
            return Err(PolicyError::Tendons { found, expected });
        }
        // A number that is not finite is `null` in JSON.
        values
            .iter()
            .map(|value| value.as_f64().ok_or(PolicyError::NotFinite("answer of the policy")))
            .collect()
    }
}

fn failed(error: PeerError) -> PolicyError {
    PolicyError::Outside(error.to_string())
}

impl OutsideDecider for ProcessDecider {
    fn sample(&mut self, seen: &Observation) -> Result<Option<Displacements>, PolicyError> {
        if self.hello.samples == 0 {
            return Ok(None);
        }
        let request = json!({ "sample": { "tip_m": seen.tip_m, "pulls_m": seen.pulls_m } });
        let answer = self.ask(&request)?;
        // The last request tells the tip of the last sample; what it is answered moves nothing.
        if answer.get("enough").is_some() || self.samples_taken == self.hello.samples {
            return Ok(None);
        }
        self.samples_taken += 1;
        self.pulls_m(&answer).map(Some)
    }

    fn reset(&mut self) -> Result<(), PolicyError> {
        self.ask(&json!({ "reset": {} })).map(drop)
    }

    fn decide(&mut self, view: &OutsideView) -> Result<OutsideDecision, PolicyError> {
        let request = json!({ "act": {
            "tip_m": view.tip_m, "target_m": view.target_m, "pulls_m": view.pulls_m, "time_s": view.time_s,
        } });
        let answer = self.ask(&request)?;
        let settled = answer.get("settled").and_then(Value::as_bool);
        Ok(OutsideDecision { pulls_m: self.pulls_m(&answer)?, settled })
    }
}
