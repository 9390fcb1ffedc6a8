//! The keys of an experiment: everything that its results depend on.

use super::claims::PaperClaim;
use super::repair::RepairRun;
use super::slurm::SlurmOptions;
use crate::base::{Seed, is_default};
use crate::benchmark::{
    CaseBatch, DrawnEffect, OracleOptions, Population, RecordedCases, TruthOptions,
};
use crate::discovery::Options;
use crate::effects::EffectSpec;
use crate::learn::gp::GpConfig;
use crate::learn::networks::NetworkConfig;
use crate::plants::{PlantSpec, RobotChange};
use crate::policies::{self, EarlyStopping, NetworkDescription, PolicyOptions};
use crate::report::figures;
use crate::tasks::{
    ExploreOptions, GpPointsOptions, LoopMode, PathOptions, ReachOptions, SimulatedBy,
    TargetOptions, TrackOptions,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// An experiment. Omitted keys take the defaults of their modules, which `docs/method/decisions.md`
/// explains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Name of its folder under `results/`.
    pub name: String,
    /// The model that generates the simulated data.
    pub model: PlantSpec,
    /// The robot that represents the real one.
    pub plant: PlantSpec,
    /// Every repetition has its own robot: `plant` with random effects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub population: Option<Population>,
    /// Control and recording rate, hertz.
    pub control_hz: f64,
    /// Root of all seeds.
    #[serde(default)]
    pub seed: u64,
    /// Number of repetitions of the whole experiment, including data and training.
    #[serde(default = "one")]
    pub seeds: u64,
    /// Number of the first repetition; earlier ones can run elsewhere.
    #[serde(default, skip_serializing_if = "is_default")]
    pub first_seed: u64,
    /// Largest displacement of a tendon for all sections, metres; a section may set its own.
    /// Default: 1.5 rad times the levers of the model's tendons. Steps are a tenth of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel_m: Option<f64>,
    /// Random exploration on the model, replayed on the robot.
    #[serde(default)]
    pub explore: ExploreOptions,
    /// Predefined training points of the Gaussian process.
    #[serde(default)]
    pub gp_points: GpPointsOptions,
    /// The Gaussian process.
    #[serde(default)]
    pub gp: GpConfig,
    /// The networks.
    #[serde(default)]
    pub network: NetworkConfig,
    /// Initial weights of policy B's network.
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
    /// When a goal-reaching trial ends.
    #[serde(default)]
    pub reach: ReachOptions,
    /// The path to track.
    #[serde(default)]
    pub path: PathOptions,
    /// When tracking advances to the next point.
    #[serde(default)]
    pub track: TrackOptions,
    /// Modes of a trial by name.
    #[serde(default)]
    pub modes: BTreeMap<String, TrialMode>,
    /// The runs.
    pub runs: Runs,
    /// Tables and figures to render, by name.
    #[serde(default)]
    #[schemars(schema_with = "figure_names")]
    pub figures: Vec<String>,
    /// The paper's claims about it. They are evaluated if `model` and `plant` have the length and
    /// the tendons of the paper's robot.
    #[serde(default)]
    pub claims: Vec<PaperClaim>,
    /// Resources requested from a Slurm cluster.
    #[serde(default, skip_serializing_if = "is_default")]
    pub slurm: SlurmOptions,
}

impl Experiment {
    /// The numbers of the repetitions.
    pub fn repetitions(&self) -> std::ops::Range<u64> {
        self.first_seed..self.first_seed + self.seeds
    }

    /// Whether model and robot may be the paper's, so that its claims are about them.
    pub fn is_of_paper_robot(&self) -> bool {
        self.model.may_be_paper_robot() && self.plant.may_be_paper_robot()
    }

    /// Standard deviation of the noise in the gap between simulated and measured tip, metres: that
    /// of `plant`, and of `model` where the simulated tip is measured on it. `None` for a robot
    /// whose options do not tell it.
    pub fn gap_noise_m(&self) -> Option<f64> {
        let model_noise_m = match self.gp_points.p_sim {
            SimulatedBy::Rod => self.model.noise_m().unwrap_or(0.0),
            SimulatedBy::Network => 0.0,
        };
        self.plant.noise_m().map(|noise_m| noise_m.hypot(model_noise_m))
    }

    /// The settings of the Gaussian process, with the noise that its prior leaves to the robot.
    pub fn gp_config(&self) -> GpConfig {
        let mut gp = self.gp.clone();
        if let Some(prior) = &mut gp.noise_prior {
            prior.std_m = prior.std_m.or_else(|| self.gap_noise_m());
        }
        gp
    }

    /// What the robot of a repetition has beside `plant`, where repetitions differ in their robots.
    pub fn drawn_effects(&self, repetition: u64) -> Vec<DrawnEffect> {
        let (Some(population), Some(model)) = (&self.population, self.plant.model()) else {
            return Vec::new();
        };
        population.draw(model, Seed(self.seed).child("population").index(repetition))
    }
}

fn one() -> u64 {
    1
}

fn policy_names(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let names: Vec<&str> = policies::REGISTRY.iter().map(|entry| entry.name).collect();
    // The second form is that of policies from outside.
    let item =
        serde_json::json!({ "anyOf": [{ "type": "string", "enum": names }, { "type": "string" }] });
    schemars::json_schema!({ "type": "array", "items": item })
}

fn figure_names(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let names: Vec<&str> = figures().map(|figure| figure.name).collect();
    schemars::json_schema!({ "type": "array", "items": { "type": "string", "enum": names } })
}

/// Initial weights of policy B's network when it is trained on generated data.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum GeneratedStart {
    /// The weights of policy A's network ("we can retrain the RNN in control policy A").
    #[default]
    Trained,
    /// Random weights.
    Random,
}

/// A kind of training: the validation errors at which networks stop training early.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Training {
    /// Validation mean absolute error at which the forward model stops, metres; `null`: train to
    /// convergence.
    pub forward_mae_m: Option<f64>,
    /// The same for the inverse mapping of simulated data.
    pub inverse_mae_m: Option<f64>,
    /// The same for the inverse mapping of generated data (policy B).
    pub inverse_b_mae_m: Option<f64>,
    /// The same for the inverse mapping of real data (π_real).
    pub pi_real_mae_m: Option<f64>,
}

impl Training {
    /// Validation error at which a network is taken, metres.
    pub fn stop_m(&self, network: &NetworkDescription) -> Option<f64> {
        match network.early_stopping {
            EarlyStopping::Forward => self.forward_mae_m,
            EarlyStopping::Inverse => self.inverse_mae_m,
            EarlyStopping::InverseB => self.inverse_b_mae_m,
            EarlyStopping::PiReal => self.pi_real_mae_m,
            EarlyStopping::At(error_m) => Some(error_m),
            EarlyStopping::Never => None,
        }
    }
}

/// The mode of a trial: feedback and added effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrialMode {
    /// Whether the policy observes the tip after the first step.
    pub feedback: LoopMode,
    /// Effects added to the robot.
    #[serde(default)]
    pub effects: Vec<EffectSpec>,
    /// A change of the robot during each trial.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<RobotChange>,
}

impl TrialMode {
    /// True when the policy observes nothing after the first step.
    pub fn is_open(&self) -> bool {
        self.feedback == LoopMode::Open
    }
}

/// The runs of an experiment. Each part is one table of results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Runs {
    /// The exploration on model and robot, sample by sample (Fig. 5).
    pub gap: Option<GapRun>,
    /// The forward model of eq. (17), which no policy uses.
    pub forward: bool,
    /// Sizes of further Gaussian processes, in addition to those of the policies.
    pub gp_points: Vec<usize>,
    /// Nominal coverages of intervals of the Gaussian processes, tested on unseen points.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gp_coverage: Vec<f64>,
    /// Nominal coverages, tested on each point as predicted from the others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gp_leave_one_out: Vec<f64>,
    /// Goal reaching: products of policies, modes and sizes.
    pub reach: Vec<ReachSweep>,
    /// Path tracking.
    pub track: Option<TrackRun>,
    /// Trials of fixed duration: speed and directness of reaching a target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub response: Option<ResponseRun>,
    /// Laps of the path in time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pace: Option<PaceRun>,
    /// Unannounced changes of the robot, and their repair.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repair: Option<RepairRun>,
    /// Blind cases of discovery, for the model.
    pub discovery: Option<DiscoveryRun>,
}

/// Blind cases of discovery. Commands are those of `explore`, with the trials and samples of each
/// batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscoveryRun {
    /// Options of the discovery.
    #[serde(default)]
    pub options: Options,
    /// Resolution of the simulated truth.
    #[serde(default)]
    pub truth: TruthOptions,
    /// Criterion for disturbances outside the span of the catalogue.
    #[serde(default)]
    pub oracle: OracleOptions,
    /// Hidden effects, their size and their number.
    #[serde(default)]
    pub batches: Vec<CaseBatch>,
    /// External recordings with known truth; every repetition uses all of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recordings: Vec<RecordedCases>,
}

/// The comparison of the exploration on model and robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GapRun {
    /// Number of published samples for each seed, evenly spread over the exploration.
    pub rows: usize,
}

/// A product of policies, modes and data sizes. A size applies to the policies that use it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReachSweep {
    /// Policies.
    #[schemars(schema_with = "policy_names")]
    pub policies: Vec<String>,
    /// Modes; open-loop modes do not apply to a policy for closed loop only ("N/A").
    pub modes: Vec<String>,
    /// Real points of the Gaussian process.
    #[serde(default)]
    pub gp_points: Option<Vec<usize>>,
    /// Real points of π_real's network.
    #[serde(default)]
    pub real_points: Option<Vec<usize>>,
}

/// Trials of fixed duration on the targets of goal reaching, whether the policy has settled or not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResponseRun {
    /// Duration of a trial, seconds: 1 to 600.
    #[serde(default = "response_s")]
    pub duration_s: f64,
    /// Products of policies, modes and sizes.
    pub cells: Vec<ReachSweep>,
}

/// Duration of a response: twice the 5 s of its last error before the end.
fn response_s() -> f64 {
    10.0
}

/// Laps of the path at constant speed: the target moves with time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaceRun {
    /// Time for a lap at speed 1, seconds; the paper's policy A took 135 s.
    #[serde(default = "paper_lap_s")]
    pub lap_s: f64,
    /// Speeds as multiples of that.
    pub speeds: Vec<f64>,
    /// Time at the first point before the lap, seconds: 1 to 600.
    #[serde(default = "response_s")]
    pub lead_in_s: f64,
    /// Products of policies, modes and sizes.
    pub cells: Vec<ReachSweep>,
}

fn paper_lap_s() -> f64 {
    135.0
}

/// Path tracking.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackRun {
    /// Policies.
    #[schemars(schema_with = "policy_names")]
    pub policies: Vec<String>,
    /// Mode.
    pub mode: String,
    /// Real points of the Gaussian process, for the policies that use one.
    #[serde(default)]
    pub gp_points: Option<usize>,
    /// Real points of π_real's network.
    #[serde(default)]
    pub real_points: Option<usize>,
}
