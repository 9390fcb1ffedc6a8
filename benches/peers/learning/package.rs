//! A package in a Python process of its own that stays up over all rounds: a line asks for a task,
//! a line answers.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::Value;

use super::task::{Outcome, Task};

/// Names in the table and scripts, in the order of the table.
pub const PACKAGES: [(&str, &str); 5] = [
    ("scipy", "gp_scipy.py"),
    ("scikit_learn", "gp_scikit_learn.py"),
    ("gpy", "gp_gpy.py"),
    ("gpytorch", "gp_gpytorch.py"),
    ("pytorch", "elman_pytorch.py"),
];

/// A running script.
pub struct Package {
    pub name: &'static str,
    /// Packages and versions.
    pub versions: Vec<(String, String)>,
    tasks: Vec<String>,
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    log: PathBuf,
}

impl Package {
    /// Starts `script` on the samples in `scratch`, with one thread.
    ///
    /// # Errors
    /// Why it does not run: no Python, a package that is not installed.
    pub fn start(name: &'static str, script: &str, scratch: &Path) -> Result<Package, String> {
        let program = std::env::var_os("PEERS_PYTHON").filter(|name| !name.is_empty());
        let program =
            PathBuf::from(program.ok_or("no Python environment (PEERS_PYTHON is not set)")?);
        let log = scratch.join(format!("{name}.log"));
        let words = |error: std::io::Error| format!("{}: {error}", program.display());
        let threads =
            ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"].map(|name| (name, "1"));
        let mut child = Command::new(&program)
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers/learning").join(script))
            .arg(scratch)
            .envs(threads)
            .env("PYTHONPYCACHEPREFIX", scratch)
            // A kernel that somebody chose for other work would slow NumPy down.
            .env_remove("OPENBLAS_CORETYPE")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(File::create(&log).map_err(words)?)
            .spawn()
            .map_err(words)?;
        let (requests, answers) =
            child.stdin.take().zip(child.stdout.take()).ok_or("no pipes to the script")?;
        let answers = BufReader::new(answers);
        let mut package = Package {
            name,
            versions: Vec::new(),
            tasks: Vec::new(),
            child,
            requests,
            answers,
            log,
        };
        let hello = package.answer()?;
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        package.tasks = hello["tasks"].as_array().into_iter().flatten().map(text).collect();
        let versions = hello["versions"].as_object().into_iter().flatten();
        package.versions = versions.map(|(name, version)| (name.clone(), text(version))).collect();
        Ok(package)
    }

    /// Whether it has such a task.
    pub fn does(&self, task: Task) -> bool {
        self.tasks.iter().any(|name| name == task.name)
    }

    /// Carries out a task.
    ///
    /// # Errors
    /// What the script said.
    pub fn run(&mut self, task: Task, round: u64) -> Result<Outcome, String> {
        writeln!(self.requests, "{} {} {round}", task.name, task.size)
            .map_err(|error| error.to_string())?;
        let answer = self.answer()?;
        if let Some(reason) = answer["failed"].as_str() {
            return Err(reason.to_owned());
        }
        let number = |key: &str| answer[key].as_f64().unwrap_or(f64::NAN);
        Ok(Outcome {
            cpu_s: number("cpu_s"),
            likelihood: number("likelihood"),
            evaluations: number("evaluations"),
            error_m: number("error_m"),
        })
    }

    fn answer(&mut self) -> Result<Value, String> {
        let mut line = String::new();
        let read = self.answers.read_line(&mut line).map_err(|error| error.to_string())?;
        if read == 0 {
            let said = std::fs::read_to_string(&self.log).unwrap_or_default();
            return Err(said.lines().last().unwrap_or("it ended without a word").to_owned());
        }
        serde_json::from_str(&line).map_err(|error| error.to_string())
    }
}

impl Drop for Package {
    fn drop(&mut self) {
        // One that waits for requests ends at once; one that hangs must not outlive the comparison.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
