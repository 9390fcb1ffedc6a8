//! A policy that is a network in an ONNX file.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::controller::{OutsideDecider, OutsideDecision, OutsideView};
use crate::base::{BadOption, PolicyError, is_default};
use crate::learn::onnx::OnnxNetwork;

/// Options of a policy in an ONNX file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OnnxOptions {
    /// The file, relative to that of the spec.
    pub file: PathBuf,
    /// What the network sees, in this order.
    #[serde(default = "seen")]
    pub inputs: Vec<OnnxInput>,
    /// What it decides.
    #[serde(default)]
    pub output: OnnxOutput,
    /// True when it decides by the measured error, so that open loop means nothing to it; so it is
    /// with changes as `output`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub closed_loop_only: bool,
    /// Positions are divided by this before the network sees them, metres.
    #[serde(default = "one")]
    pub position_scale_m: f64,
    /// Displacements are divided by this before the network sees them, and what it decides is
    /// multiplied by this, metres.
    #[serde(default = "one")]
    pub pull_scale_m: f64,
    /// The policy has settled when the tip is this near to the target, or when it repeats its
    /// command, metres.
    #[serde(default = "settled_m")]
    pub settled_m: f64,
}

/// A part of what a network sees.
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

/// What a network decides.
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
        BadOption::unless_counted("inputs", self.inputs.len())
    }

    fn input_size(&self, tendons: usize) -> usize {
        self.inputs.iter().map(|input| if *input == OnnxInput::Pulls { tendons } else { 3 }).sum()
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
        (error.to_string(), "an ONNX file of a feed-forward network (docs/python.md)".to_owned())
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
}

impl OnnxDecider {
    pub(super) fn new(
        options: &OnnxOptions,
        content: &[u8],
        tendons: usize,
    ) -> Result<OnnxDecider, (String, String)> {
        Ok(OnnxDecider { network: read(options, content, tendons)?, options: options.clone() })
    }
}

impl OutsideDecider for OnnxDecider {
    fn reset(&mut self) -> Result<(), PolicyError> {
        Ok(())
    }

    fn decide(&mut self, view: &OutsideView) -> Result<OutsideDecision, PolicyError> {
        let OnnxOptions { position_scale_m, pull_scale_m, .. } = self.options;
        let mut input = Vec::with_capacity(self.network.inputs());
        for part in &self.options.inputs {
            match part {
                OnnxInput::Tip => {
                    input.extend(view.tip_m.iter().map(|value| value / position_scale_m))
                }
                OnnxInput::Target => {
                    input.extend(view.target_m.iter().map(|value| value / position_scale_m))
                }
                OnnxInput::Error => {
                    input.extend(
                        (0..3).map(|axis| {
                            (view.target_m[axis] - view.tip_m[axis]) / position_scale_m
                        }),
                    );
                }
                OnnxInput::Pulls => {
                    input.extend(view.pulls_m.iter().map(|value| value / pull_scale_m))
                }
            }
        }
        let output = self
            .network
            .evaluate(&input)
            .map_err(|error| PolicyError::Outside(error.to_string()))?;
        PolicyError::unless_finite("output of the network", &output)?;
        let pulls_m = output.iter().enumerate().map(|(tendon, value)| match self.options.output {
            OnnxOutput::Pulls => pull_scale_m * value,
            OnnxOutput::Changes => {
                view.pulls_m.get(tendon).copied().unwrap_or_default() + pull_scale_m * value
            }
        });
        Ok(OutsideDecision { pulls_m: pulls_m.collect(), settled: None })
    }
}
