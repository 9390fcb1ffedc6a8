//! What an experiment is: everything that its results depend on.

use super::claims::PaperClaim;
use super::plant::PlantSpec;
use super::slurm::SlurmOptions;
use crate::benchmark::{CaseBatch, OracleOptions, TruthOptions};
use crate::discovery::Options;
use crate::effects::EffectSpec;
use crate::learn::gp::GpConfig;
use crate::learn::rnn::ElmanConfig;
use crate::policies::PolicyOptions;
use crate::tasks::{ExploreOptions, GpPointsOptions, LoopMode, PathOptions, ReachOptions, TargetOptions, TrackOptions};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// An experiment. Keys that a spec leaves out take the defaults of their rooms, each argued in `docs/decisions.md`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Name of its folder under `results/`.
    pub name: String,
    /// The model that the simulated data come from.
    pub model: PlantSpec,
    /// The robot that stands for the real one.
    pub plant: PlantSpec,
    /// Control and recording rate, hertz.
    pub control_hz: f64,
    /// Root of all seeds.
    #[serde(default)]
    pub seed: u64,
    /// Repetitions of the whole experiment, data and training included.
    #[serde(default = "one")]
    pub seeds: u64,
    /// Number of the first repetition: those before it are left to another machine or night.
    #[serde(default, skip_serializing_if = "is_default")]
    pub first_seed: u64,
    /// Random exploration on the model, replayed on the robot.
    #[serde(default)]
    pub explore: ExploreOptions,
    /// Predefined points of the Gaussian process.
    #[serde(default)]
    pub gp_points: GpPointsOptions,
    /// The Gaussian process.
    #[serde(default)]
    pub gp: GpConfig,
    /// The networks.
    #[serde(default)]
    pub network: ElmanConfig,
    /// What policy B's network starts from.
    #[serde(default)]
    pub generated_start: GeneratedStart,
    /// Kinds of training by name.
    pub training: BTreeMap<String, Training>,
    /// The policies.
    #[serde(default)]
    pub policies: PolicyOptions,
    /// Targets of goal reaching.
    #[serde(default)]
    pub targets: TargetOptions,
    /// When a trial of goal reaching ends.
    #[serde(default)]
    pub reach: ReachOptions,
    /// The path that is tracked.
    #[serde(default)]
    pub path: PathOptions,
    /// When tracking moves on.
    #[serde(default)]
    pub track: TrackOptions,
    /// Conditions of a trial by name.
    #[serde(default)]
    pub modes: BTreeMap<String, TrialMode>,
    /// What is run.
    pub runs: Runs,
    /// Tables and figures that are made of the results, by name.
    #[serde(default)]
    pub figures: Vec<String>,
    /// What the paper claims of it.
    #[serde(default)]
    pub claims: Vec<PaperClaim>,
    /// What a Slurm cluster is asked for.
    #[serde(default, skip_serializing_if = "is_default")]
    pub slurm: SlurmOptions,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Experiment {
    /// The numbers of the repetitions.
    pub fn repetitions(&self) -> std::ops::Range<u64> {
        self.first_seed..self.first_seed + self.seeds
    }
}

fn one() -> u64 {
    1
}

/// What the network of policy B starts from when it is trained on generated data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GeneratedStart {
    /// The weights of policy A's network ("we can retrain the RNN in control policy A").
    #[default]
    Trained,
    /// Random weights.
    Random,
}

/// A kind of training: where it may end before its validation error stops falling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Training {
    /// Validation mean absolute error at which the forward model is taken, metres; `null`: trained to convergence.
    pub forward_mae_m: Option<f64>,
    /// The same for the inverse mapping of simulated data.
    pub inverse_mae_m: Option<f64>,
    /// The same for the inverse mapping of generated data (policy B).
    pub inverse_b_mae_m: Option<f64>,
    /// The same for the inverse mapping of real data (π_real).
    pub pi_real_mae_m: Option<f64>,
}

/// A condition of a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrialMode {
    /// Whether the policy sees the tip after the first step.
    pub feedback: LoopMode,
    /// Effects that the robot has on top of its own.
    #[serde(default)]
    pub effects: Vec<EffectSpec>,
}

impl TrialMode {
    /// True when the policy sees nothing after the first step.
    pub fn is_open(&self) -> bool {
        self.feedback == LoopMode::Open
    }
}

/// What is run. Each part is one table of results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Runs {
    /// The exploration on model and robot side by side (Fig. 5).
    pub gap: Option<GapRun>,
    /// The forward model of eq. (17), which no policy uses.
    pub forward: bool,
    /// Gaussian processes of these sizes, beyond those that policies use.
    pub gp_points: Vec<usize>,
    /// Goal reaching: products of policies, modes and sizes.
    pub reach: Vec<ReachSweep>,
    /// Path tracking.
    pub track: Option<TrackRun>,
    /// Blind cases of discovery, about the model.
    pub discovery: Option<DiscoveryRun>,
}

/// Blind cases of discovery. Commands are those of `explore`, with the trials and samples of each batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscoveryRun {
    /// How each recording is looked into.
    #[serde(default)]
    pub options: Options,
    /// How finely the truth is computed.
    #[serde(default)]
    pub truth: TruthOptions,
    /// When something is outside the span of the catalogue.
    #[serde(default)]
    pub oracle: OracleOptions,
    /// What is hidden, how strongly and how often.
    pub batches: Vec<CaseBatch>,
}

/// The exploration side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GapRun {
    /// Samples that are published for each seed, evenly spread over the exploration.
    pub rows: usize,
}

/// A product of policies, modes and data sizes. A size counts for the policies that use it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReachSweep {
    /// Policies.
    pub policies: Vec<String>,
    /// Modes; a policy that only works in closed loop leaves out the others ("N/A").
    pub modes: Vec<String>,
    /// Real points of the Gaussian process.
    #[serde(default)]
    pub gp_points: Option<Vec<usize>>,
    /// Real points of π_real's network.
    #[serde(default)]
    pub real_points: Option<Vec<usize>>,
}

/// Tracking of the path by some policies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackRun {
    /// Policies.
    pub policies: Vec<String>,
    /// TrialMode.
    pub mode: String,
    /// Real points of the Gaussian process, for the policies that use one.
    #[serde(default)]
    pub gp_points: Option<usize>,
    /// Real points of π_real's network.
    #[serde(default)]
    pub real_points: Option<usize>,
}
