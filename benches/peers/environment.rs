//! What the figures were measured on, and what was found on the way.

use std::process::Command;

use serde::Serialize;

use crate::clock;

/// What is worth knowing besides the rows.
#[derive(Debug, Default, Serialize)]
pub struct Facts {
    /// Versions of the packages.
    pub versions: Vec<(String, String)>,
    /// Peers that did not run, and why.
    pub skipped: Vec<(String, String)>,
    /// How far apart two ways to the same limit are, metres.
    pub limits_m: Vec<(String, f64)>,
}

/// What all figures depend on.
#[derive(Debug, Serialize)]
pub struct Machine {
    processor: String,
    time: &'static str,
    system: String,
    compiler: String,
    spinebench: &'static str,
}

impl Machine {
    /// The one that this runs on.
    pub fn this() -> Machine {
        Machine {
            processor: processor(),
            time: clock::kind(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            compiler: compiler(),
            spinebench: env!("CARGO_PKG_VERSION"),
        }
    }
}

#[derive(Serialize)]
struct Environment {
    #[serde(flatten)]
    machine: Machine,
    versions: serde_json::Map<String, serde_json::Value>,
    skipped: serde_json::Map<String, serde_json::Value>,
    limits_m: serde_json::Map<String, serde_json::Value>,
}

/// The facts and the machine as YAML.
///
/// # Errors
/// What the serialiser said.
pub fn yaml(facts: &Facts) -> Result<String, String> {
    let map = |pairs: &[(String, String)]| {
        pairs.iter().map(|(name, word)| (name.clone(), word.clone().into())).collect()
    };
    let environment = Environment {
        machine: Machine::this(),
        versions: map(&facts.versions),
        skipped: map(&facts.skipped),
        limits_m: facts
            .limits_m
            .iter()
            .map(|(name, value)| (name.clone(), (*value).into()))
            .collect(),
    };
    serde_yaml::to_string(&environment).map_err(|error| error.to_string())
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find(|line| line.starts_with("model name"))
        .and_then(|line| line.split(": ").nth(1));
    name.unwrap_or("unknown").to_owned()
}

fn compiler() -> String {
    let said = Command::new("rustc").arg("--version").output();
    said.map_or_else(
        |_| "unknown".into(),
        |said| String::from_utf8_lossy(&said.stdout).trim().to_owned(),
    )
}
