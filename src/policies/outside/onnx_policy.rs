//! A policy that is a network in an ONNX file.

use std::collections::VecDeque;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::controller::{OutsideDecider, OutsideDecision, OutsideView};
use crate::base::{BadOption, PolicyError, is_default};
use crate::learn::onnx::{OnnxMemory, OnnxNetwork};

/// Options of a policy in an ONNX file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OnnxOptions {
    /// The file, relative to that of the spec.
    pub file: PathBuf,
    /// Inputs of the network.
    #[serde(default)]
    pub inputs: OnnxInputs,
    /// Output of the network.
    #[serde(default)]
    pub output: OnnxOutput,
    /// True if it uses the measured error and cannot run in open loop; always true with changes as
    /// `output`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub closed_loop_only: bool,
    /// Divisor of positions before the network, metres.
    #[serde(default = "one")]
    pub position_scale_m: f64,
    /// Divisor of displacements before the network and factor on its output, metres.
    #[serde(default = "one")]
    pub pull_scale_m: f64,
    /// The policy has settled when the tip is within this distance of the target or the command
    /// repeats, metres.
    #[serde(default = "settled_m")]
    pub settled_m: f64,
}

/// What a network sees: parts in this order, in the last tick or in several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "a list of `tip`, `target`, `error` and `pulls`, or `{window: TICKS, each: [tip, …]}`"
)]
pub enum OnnxInputs {
    /// These, as they are now.
    Now(Vec<OnnxInput>),
    /// These in each of the last ticks, the oldest first.
    Past(OnnxWindow),
}

/// The last ticks of a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OnnxWindow {
    /// Number of ticks, 1 to 1000. At the start of a trial the first tick is repeated.
    pub window: usize,
    /// Inputs from each tick.
    #[serde(default = "seen")]
    pub each: Vec<OnnxInput>,
}

impl Default for OnnxInputs {
    fn default() -> Self {
        OnnxInputs::Now(seen())
    }
}

impl OnnxInputs {
    /// What is seen of a tick.
    fn each(&self) -> &[OnnxInput] {
        match self {
            OnnxInputs::Now(each) => each,
            OnnxInputs::Past(past) => &past.each,
        }
    }

    /// Number of ticks.
    fn ticks(&self) -> usize {
        match self {
            OnnxInputs::Now(_) => 1,
            OnnxInputs::Past(past) => past.window,
        }
    }
}

/// Most ticks that a network may see.
const MAX_WINDOW: usize = 1000;

/// An input of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnnxInput {
    /// Measured tip (3 numbers).
    Tip,
    /// Target (3 numbers).
    Target,
    /// Target minus tip (3 numbers).
    Error,
    /// The displacements in force (one number per tendon).
    Pulls,
}

/// Output of a network.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum OnnxOutput {
    /// The displacement of each tendon.
    #[default]
    Pulls,
    /// The change of each displacement in this step: for closed loop only.
    Changes,
}

fn seen() -> Vec<OnnxInput> {
    vec![OnnxInput::Tip, OnnxInput::Target, OnnxInput::Pulls]
}

fn one() -> f64 {
    1.0
}

pub(super) fn settled_m() -> f64 {
    0.001
}

impl OnnxOptions {
    pub(super) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("position_scale_m", self.position_scale_m)?;
        BadOption::unless_positive("pull_scale_m", self.pull_scale_m)?;
        BadOption::unless_positive("settled_m", self.settled_m)?;
        let ticks = self.inputs.ticks();
        BadOption::unless_within("window", ticks, 1..=MAX_WINDOW, "a whole number from 1 to 1000")?;
        BadOption::unless_counted("inputs", self.inputs.each().len())
    }

    fn input_size(&self, tendons: usize) -> usize {
        let size = |input: &OnnxInput| if *input == OnnxInput::Pulls { tendons } else { 3 };
        self.inputs.ticks() * self.inputs.each().iter().map(size).sum::<usize>()
    }
}

/// Reads the network and checks its sizes.
pub(super) fn read(
    options: &OnnxOptions,
    content: &[u8],
    tendons: usize,
) -> Result<OnnxNetwork, (String, String)> {
    let size = options.input_size(tendons);
    let network = OnnxNetwork::read(content, size).map_err(|error| {
        (error.to_string(), "an ONNX file of a network (docs/reference/python.md)".to_owned())
    })?;
    if network.inputs() != size {
        let expected = format!("{size}, the size of `inputs` for {tendons} tendons");
        return Err((format!("a network with {} inputs", network.inputs()), expected));
    }
    if network.outputs() != tendons {
        let expected = format!("{tendons}, one for each tendon");
        return Err((format!("a network with {} outputs", network.outputs()), expected));
    }
    Ok(network)
}

/// The network as a policy.
pub(super) struct OnnxDecider {
    network: OnnxNetwork,
    options: OnnxOptions,
    memory: OnnxMemory,
    /// What was seen of the last ticks, the oldest first.
    past: VecDeque<Vec<f64>>,
}

impl OnnxDecider {
    pub(super) fn new(
        options: &OnnxOptions,
        content: &[u8],
        tendons: usize,
    ) -> Result<OnnxDecider, (String, String)> {
        Ok(OnnxDecider {
            network: read(options, content, tendons)?,
            options: options.clone(),
            memory: OnnxMemory::default(),
            past: VecDeque::new(),
        })
    }

    /// What is seen of this tick.
    fn seen(&self, view: &OutsideView) -> Vec<f64> {
        let OnnxOptions { position_scale_m, pull_scale_m, .. } = self.options;
        let mut seen = Vec::with_capacity(self.network.inputs());
        for part in self.options.inputs.each() {
            match part {
                OnnxInput::Tip => {
                    seen.extend(view.tip_m.iter().map(|value| value / position_scale_m))
                }
                OnnxInput::Target => {
                    seen.extend(view.target_m.iter().map(|value| value / position_scale_m))
                }
                OnnxInput::Error => {
                    seen.extend(
                        (0..3).map(|axis| {
                            (view.target_m[axis] - view.tip_m[axis]) / position_scale_m
                        }),
                    );
                }
                OnnxInput::Pulls => {
                    seen.extend(view.pulls_m.iter().map(|value| value / pull_scale_m))
                }
            }
        }
        seen
    }

    /// The network's input: this tick and those before it, as many as it sees.
    fn input(&mut self, view: &OutsideView) -> Vec<f64> {
        let seen = self.seen(view);
        let ticks = self.options.inputs.ticks();
        self.past.resize(ticks.max(self.past.len()), seen.clone());
        self.past.pop_front();
        self.past.push_back(seen);
        self.past.iter().flatten().copied().collect()
    }
}

impl OutsideDecider for OnnxDecider {
    fn reset(&mut self) -> Result<(), PolicyError> {
        self.memory = OnnxMemory::default();
        self.past.clear();
        Ok(())
    }

    fn decide(&mut self, view: &OutsideView) -> Result<OutsideDecision, PolicyError> {
        let input = self.input(view);
        if matches!(self.options.inputs, OnnxInputs::Past(_)) {
            // The window holds what is to be remembered.
            self.memory = OnnxMemory::default();
        }
        let output = self
            .network
            .evaluate_next(&input, &mut self.memory)
            .map_err(|error| PolicyError::Outside(error.to_string()))?;
        PolicyError::unless_finite("output of the network", &output)?;
        let pull_scale_m = self.options.pull_scale_m;
        let pulls_m = output.iter().enumerate().map(|(tendon, value)| match self.options.output {
            OnnxOutput::Pulls => pull_scale_m * value,
            OnnxOutput::Changes => {
                view.pulls_m.get(tendon).copied().unwrap_or_default() + pull_scale_m * value
            }
        });
        Ok(OutsideDecision { pulls_m: pulls_m.collect(), settled: None })
    }
}
