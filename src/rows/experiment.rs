//! The rows that experiments publish; each becomes a line of a CSV under `results/`, with these
//! field names as columns.

use super::cell::{CellLabel, CellRow, CellValue, Outcome};
use crate::base::Point3;
use crate::data::{TableDescription, TableRow, columns, table_rows};

columns! {
    /// One goal-reaching trial (Table I, Fig. 6).
    pub struct ReachTrial {
        /// Number of the target in its draw; the same for every policy of a seed.
        pub target: u64,
        /// Target, metres.
        pub target_x_m: f64,
        /// Target, metres.
        pub target_y_m: f64,
        /// Target, metres.
        pub target_z_m: f64,
        /// Last measured tip, including tracking noise, metres; not a number if it was never
        /// measured.
        pub tip_x_m: f64,
        /// Tip, metres.
        pub tip_y_m: f64,
        /// Tip, metres.
        pub tip_z_m: f64,
        /// Distance of the tip from the target; with `reach.averaged_samples` above 1 the mean
        /// distance over that number of last measurements, metres.
        pub error_m: f64,
        /// Control steps taken.
        pub steps: u64,
        /// Whether the policy settled before the step limit.
        pub settled: bool,
        /// Number of changes of the command's source between A and B (0 for policies of one
        /// controller).
        pub switches: u64,
        /// `ok` or the named failure; a failed trial is counted and excluded from the means.
        pub status: Outcome,
    }

    /// One control step of path tracking.
    pub struct TrackSample {
        /// Control step.
        pub step: u64,
        /// Time since the start, seconds.
        pub time_s: f64,
        /// Number of the interpolated path point that is the target.
        pub path_point: u64,
        /// Target, metres.
        pub target_x_m: f64,
        /// Target, metres.
        pub target_y_m: f64,
        /// Target, metres.
        pub target_z_m: f64,
        /// Tip, metres.
        pub tip_x_m: f64,
        /// Tip, metres.
        pub tip_y_m: f64,
        /// Tip, metres.
        pub tip_z_m: f64,
        /// Distance to the target, metres.
        pub error_m: f64,
        /// Controller of the command, A or B (`a`, `b`; empty for policies of one controller).
        pub branch: String,
        /// Displacements of the tendons during the step in whole micrometres, separated by spaces,
        /// metres: only in the first repetition, to simulate its motion again. Tables of earlier
        /// builds do not have the column.
        #[serde(default)]
        pub pulls_m: String,
        /// `ok` or the named failure.
        pub status: Outcome,
    }

    /// The tip of the model and of the robot under the same command.
    pub struct GapSample {
        /// Sample number.
        pub sample: u64,
        /// Displacements of the first four tendons, metres; empty where the robot has fewer.
        pub tendon_1_m: f64,
        /// Displacement, metres.
        pub tendon_2_m: f64,
        /// Displacement, metres.
        pub tendon_3_m: f64,
        /// Displacement, metres.
        pub tendon_4_m: f64,
        /// Displacements of further tendons, separated by spaces, metres; the column exists only
        /// for robots with more than four.
        #[serde(default)]
        pub further_tendons_m: String,
        /// Simulated tip, metres.
        pub sim_x_m: f64,
        /// Simulated tip, metres.
        pub sim_y_m: f64,
        /// Simulated tip, metres.
        pub sim_z_m: f64,
        /// Measured tip, metres.
        pub real_x_m: f64,
        /// Measured tip, metres.
        pub real_y_m: f64,
        /// Measured tip, metres.
        pub real_z_m: f64,
    }

    /// How well a Gaussian process fits.
    pub struct GpScore {
        /// Real points that it was fitted to.
        pub points: u64,
        /// Kernel by its registry name.
        pub kernel: String,
        /// Cross-validated mean absolute error of the predicted gap, mean over x, y and z, metres.
        pub cross_validation_mae_m: f64,
        /// Log marginal likelihood, summed over the three outputs.
        pub log_marginal_likelihood: f64,
        /// Fitted noise standard deviation per axis, metres.
        pub noise_x_m: f64,
        /// Fitted noise, metres.
        pub noise_y_m: f64,
        /// Fitted noise, metres.
        pub noise_z_m: f64,
        /// Hyper-parameters at an end of their range (docs/method/learning.md), by axis, as `x
        /// length 3 high; y noise variance low`: noise at its lower end makes intervals too narrow;
        /// a length-scale at its upper end means an input without influence. Tables of earlier
        /// builds do not have the column.
        #[serde(default)]
        pub at_range_end: String,
    }

    /// How often one interval of a Gaussian process covers what was measured.
    pub struct GpCoverage {
        /// Real points that it was fitted to.
        pub points: u64,
        /// Kernel by its registry name.
        pub kernel: String,
        /// Axis of the gap: `x`, `y` or `z`.
        pub axis: String,
        /// Nominal coverage of the interval of process and noise.
        pub promised: f64,
        /// Share of points within the interval.
        pub covered: f64,
        /// Number of points not used in the fit.
        pub unseen: u64,
    }

    /// How a Gaussian process predicts its own points along one axis, each from all others.
    pub struct GpLeftOut {
        /// Real points that it was fitted to.
        pub points: u64,
        /// Kernel by its registry name.
        pub kernel: String,
        /// Axis of the gap: `x`, `y` or `z`.
        pub axis: String,
        /// Mean absolute error of the prediction of a left-out point, metres.
        pub mae_m: f64,
        /// Mean logarithm of its probability density as predicted from the others, per metre.
        pub log_probability: f64,
        /// Nominal coverage of the interval of process and noise.
        pub promised: f64,
        /// Share of points within the interval.
        pub covered: f64,
    }
}

/// A goal-reaching trial with its cell.
pub type TrialRow = CellRow<ReachTrial>;

/// The tables of cells of this file.
pub const CELL_TABLES: &[TableDescription] = &[TrialRow::TABLE];

impl CellValue for ReachTrial {
    const ROW: &'static str = "TrialRow";
    const FILE: &'static str = "trials.csv";
    const ABOUT: &'static str = "One goal-reaching trial (Table I, Fig. 6).";
    const KEY: &'static [&'static str] = &["target"];

    fn status(&self) -> &Outcome {
        &self.status
    }
}

impl ReachTrial {
    /// A trial that a failure before it made impossible.
    pub fn unmeasured(target: u64, status: Outcome) -> ReachTrial {
        ReachTrial::new(target, [f64::NAN; 3], [f64::NAN; 3], status)
    }

    /// A trial with a target and a last tip, metres.
    pub fn new(target: u64, target_m: Point3, tip_m: Point3, status: Outcome) -> ReachTrial {
        let ([target_x_m, target_y_m, target_z_m], [tip_x_m, tip_y_m, tip_z_m]) = (target_m, tip_m);
        ReachTrial {
            target,
            target_x_m,
            target_y_m,
            target_z_m,
            tip_x_m,
            tip_y_m,
            tip_z_m,
            error_m: f64::NAN,
            steps: 0,
            settled: false,
            switches: 0,
            status,
        }
    }
}

impl TrackSample {
    /// The first sample of a run, with a target and a tip, metres.
    pub fn new(target_m: Point3, tip_m: Point3, status: Outcome) -> TrackSample {
        let ([target_x_m, target_y_m, target_z_m], [tip_x_m, tip_y_m, tip_z_m]) = (target_m, tip_m);
        TrackSample {
            step: 0,
            time_s: 0.0,
            path_point: 0,
            target_x_m,
            target_y_m,
            target_z_m,
            tip_x_m,
            tip_y_m,
            tip_z_m,
            error_m: f64::NAN,
            branch: String::new(),
            pulls_m: String::new(),
            status,
        }
    }

    /// A run that a failure before it made impossible.
    pub fn unmeasured(status: Outcome) -> TrackSample {
        TrackSample::new([f64::NAN; 3], [f64::NAN; 3], status)
    }
}

table_rows! {
    "tracks.csv", key [seed, training, policy, step], failed [|row| !row.sample.status.is_ok()]:
    /// One control step of path tracking (Fig. 8).
    pub struct TrackRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// `paper` or `converged`.
        pub training: String,
        /// Name of the policy: `a`, `b`, `c`, `pi_real` …
        pub policy: String,
        flat sample: TrackSample,
    }

    "gap.csv", key [seed, sample]:
    /// The same command on the model and on the robot (Fig. 5).
    pub struct GapRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        flat gap: GapSample,
    }

    "networks.csv", key [seed, training, network, points]:
    /// One trained network.
    pub struct NetworkRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// `paper` or `converged`.
        pub training: String,
        /// `forward` (command to tip), `inverse` (tip to command, for `a`), `inverse_b` (the same
        /// from generated data, for `b`), `pi_real` (from real data) or `dagger` (from robots with
        /// different effects).
        pub network: String,
        /// Training points: real ones for `pi_real`, those of the Gaussian process for `inverse_b`,
        /// otherwise simulated ones.
        pub points: u64,
        /// Epochs until training stopped.
        pub epochs: u64,
        /// Mean absolute error on the validation rows, metres.
        pub validation_mae_m: f64,
        /// The paper's value; empty if the paper has none, metres.
        pub paper_mae_m: f64,
    }

    "gp.csv", key [seed, training, points]:
    /// One fitted Gaussian process.
    pub struct GpRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// Kind of training of the forward network that computes the simulated tip; `any` if the
        /// rod computes it.
        pub training: String,
        flat score: GpScore,
    }

    "gp_coverage.csv", key [seed, training, points, axis, promised]:
    /// How often the interval of a Gaussian process covers what was measured, over predefined
    /// points that it was not fitted to.
    pub struct GpCoverageRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// As in `gp.csv`.
        pub training: String,
        flat coverage: GpCoverage,
    }

    "gp_leave_one_out.csv", key [seed, training, points, axis, promised]:
    /// How a Gaussian process foretells each of its own points from all others.
    pub struct GpLeaveOneOutRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// As in `gp.csv`.
        pub training: String,
        flat left_out: GpLeftOut,
    }

    "claims.csv", key [experiment, claim, training]:
    /// One of the paper's claims and what became of it.
    pub struct ClaimRow {
        /// The experiment with which the claim is tested.
        pub experiment: String,
        /// Short name.
        pub claim: String,
        /// The claim in words.
        pub statement: String,
        /// The number that decides the claim, in words.
        pub quantity: String,
        /// `paper` or `converged`.
        pub training: String,
        /// The claim holds above this number, in the claim's unit; empty without such a limit.
        pub holds_above: f64,
        /// The claim holds below this number, in the claim's unit; empty without such a limit.
        pub holds_below: f64,
        /// Value reported by the paper, in the claim's unit.
        pub paper: f64,
        /// Value of this reproduction, in the same unit.
        pub ours: f64,
        /// 95 % interval over seeds.
        pub low_95: f64,
        /// 95 % interval over seeds.
        pub high_95: f64,
        /// Unit of these numbers.
        pub unit: String,
        /// Seeds behind the interval.
        pub seeds: u64,
        /// `reproduced`, `not reproduced` or `undecided`.
        pub verdict: String,
    }

    "waypoints.csv", key [seed, waypoint]:
    /// One of the points that the tracked path runs through (Fig. 8a).
    pub struct WaypointRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// Number along the path.
        pub waypoint: u64,
        /// Position, metres.
        pub x_m: f64,
        /// Position, metres.
        pub y_m: f64,
        /// Position, metres.
        pub z_m: f64,
    }

    "workspace.csv", key [seed, x_m, y_m, z_m]:
    /// A point of the real workspace, drawn behind a path (Fig. 8a).
    pub struct WorkspaceRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// Position, metres.
        pub x_m: f64,
        /// Position, metres.
        pub y_m: f64,
        /// Position, metres.
        pub z_m: f64,
    }

    "sweep.csv", key [task, training, policy, mode, gp_points, real_points]:
    /// An error at one point of a sweep, over seeds; the swept fields stand in columns before these
    /// (`sweep.csv`).
    pub struct SweepRow {
        /// Kind of error: `reach` (distance to the target at the end of a trial), `response` (the
        /// same of the true tip at the end of a trial of fixed duration), `track` (mean distance to
        /// the target over a run) or `gp` (cross-validated error of the Gaussian process).
        pub task: String,
        /// `paper`, `converged`, or `any` without a network.
        pub training: String,
        flat cell: CellLabel,
        /// Mean over seeds of the error's mean within a seed, metres.
        pub mean_m: f64,
        /// Standard deviation over seeds of that mean; empty for one seed, metres.
        pub sd_over_seeds_m: f64,
        /// 95 % interval of the mean over seeds (Student's t), metres; none for one seed.
        pub low_95_m: f64,
        /// 95 % interval, metres.
        pub high_95_m: f64,
        /// Repetitions with an error value.
        pub seeds: u64,
        /// Number of trials, runs or processes.
        pub count: u64,
        /// Those without an error value (status other than `ok`).
        pub failed: u64,
    }

    "comparisons.csv", key [field, task, training, policy, mode, gp_points, real_points]:
    /// Whether a value of a swept field differs from the field's first value, all else alike:
    /// paired by repetition, corrected for the number of comparisons; the swept fields stand in
    /// columns before these (`comparisons.csv`).
    pub struct ComparisonRow {
        /// The field whose values are compared.
        pub field: String,
        /// Its first value, the reference of the comparison with the value in the field's own
        /// column.
        pub reference: String,
        /// As in `sweep.csv`.
        pub task: String,
        /// As in `sweep.csv`.
        pub training: String,
        flat cell: CellLabel,
        /// Mean over repetitions of error minus error with the first value, metres; below zero is
        /// better than the first value.
        pub difference_m: f64,
        /// 95 % interval of that mean (Student's t), metres; not corrected.
        pub low_95_m: f64,
        /// 95 % interval, metres.
        pub high_95_m: f64,
        /// Repetitions with both error values.
        pub seeds: u64,
        /// Two-sided p-value of Student's paired t-test.
        pub p: f64,
        /// p-value after Holm's correction for all comparisons of this field and task that show any
        /// difference.
        pub p_holm: f64,
    }

    "summary.csv", key [training, policy, mode, gp_points, real_points]:
    /// Goal-reaching error over the trials of one policy, mode and data size: a cell of Table I or
    /// a point of Fig. 6.
    pub struct ReachSummaryRow {
        /// `paper` or `converged`.
        pub training: String,
        flat cell: CellLabel,
        /// Mean over seeds of the mean error over targets, metres.
        pub mean_m: f64,
        /// Standard deviation over the targets of one experiment (root mean square over seeds),
        /// metres: the number in brackets in the paper.
        pub sd_m: f64,
        /// 95 % interval for the mean over seeds (Student's t over per-seed means), metres; none
        /// for one seed.
        pub low_95_m: f64,
        /// 95 % interval, metres.
        pub high_95_m: f64,
        /// Repetitions of the whole experiment.
        pub seeds: u64,
        /// Trials with an error value.
        pub trials: u64,
        /// Trials without one (status other than `ok`).
        pub failed: u64,
        /// Share of the trials in which the policy settled before the step limit.
        pub settled_share: f64,
        /// Mean number of control steps.
        pub mean_steps: f64,
        /// The paper's mean, metres; empty if the paper has none.
        pub paper_mean_m: f64,
        /// The paper's standard deviation, metres.
        pub paper_sd_m: f64,
    }

    "summary.csv", key [seed, training, policy], failed [|row| !row.status.is_ok()]:
    /// Path tracking of one policy in one experiment (Fig. 8).
    pub struct TrackSummaryRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// `paper` or `converged`.
        pub training: String,
        /// Name of the policy: `a`, `b`, `c`, `pi_real` …
        pub policy: String,
        /// Mean distance to the target over the run, metres.
        pub mean_error_m: f64,
        /// Standard deviation of that distance, metres.
        pub sd_error_m: f64,
        /// Distance to the target at the end of the first path point, which the robot approaches
        /// from home, metres.
        pub start_error_m: f64,
        /// Time of the last row, seconds.
        pub completion_time_s: f64,
        /// The error less its centred moving mean over 5 s; median of its peak-to-peak over windows
        /// of 5 s. Drift does not contribute, an oscillation ±a contributes 2a; metres.
        pub oscillation_m: f64,
        /// Number of changes of the command's source between A and B.
        pub switches: u64,
        /// Control steps.
        pub steps: u64,
        /// `ok`, or the first status that is not.
        pub status: Outcome,
    }

    "summary.csv", key [axis]:
    /// Difference between simulated and measured tip along one axis (Fig. 5).
    pub struct GapSummaryRow {
        /// `x`, `y`, `z`, or `distance` for the length of the difference.
        pub axis: String,
        /// Mean of simulated minus measured, metres.
        pub mean_m: f64,
        /// Root mean square, metres.
        pub rms_m: f64,
        /// 95th percentile of the magnitude, metres.
        pub p95_m: f64,
        /// Largest magnitude, metres.
        pub max_m: f64,
        /// Samples.
        pub samples: u64,
        /// Repetitions of the whole experiment.
        pub seeds: u64,
    }

    "work_precision.csv", key [robot, peer, setting, segments_or_nodes, dt_s, rms_error_m], failed [|row| !row.status.is_ok()]:
    /// One setting of one simulator on one robot: work against precision (`docs/evidence/peers.md`).
    pub struct PeerRow {
        /// Robot and drive: `till`, `paper`, `paper_tension`; `paper_statics` for single
        /// equilibria.
        pub robot: String,
        /// Simulator.
        pub peer: String,
        /// Other settings, in words.
        pub setting: String,
        /// Cells, nodes, segments or elements along the robot.
        pub segments_or_nodes: f64,
        /// Largest time step; empty for equilibria.
        pub dt_s: f64,
        /// Processor time per simulated second; for equilibria per solve, in seconds.
        pub cpu_s_per_s: f64,
        /// Simulated time per processor time; not a number for a static solve.
        pub real_time_factor: f64,
        /// Root mean square distance of the tip from the converged solution, metres.
        pub rms_error_m: f64,
        /// Largest such distance, metres.
        pub max_error_m: f64,
        /// Distance at rest, before anything moves, metres.
        pub static_error_m: f64,
        /// `ok` or the named failure; a failed run has no other numbers.
        pub status: Outcome,
    }

    "stages.csv", key [stage, label, key]:
    /// One stage behind an experiment's results: what it was filed under, what came out and what it
    /// took.
    pub struct StageRow {
        /// Kind of stage.
        pub stage: String,
        /// Stage within its kind.
        pub label: String,
        /// First 12 digits of the digest of all dependencies including the code, as in `cache
        /// list`.
        pub key: String,
        /// First 12 digits of the digest of the result; empty if the stage failed or its result
        /// could not be stored.
        pub result: String,
        /// Wall time of the computation, seconds.
        pub wall_s: f64,
        /// Processor time of the computation over all threads, seconds.
        pub cpu_s: f64,
    }

    "scaling.csv", key [system, workers]:
    /// How long a campaign takes on so many workers.
    pub struct ScalingRow {
        /// `threads`, `two processes apart` and `everything stored` (measured), `ideal cluster` and
        /// `workers` (replayed).
        pub system: String,
        /// Threads, or nodes of one processor each.
        pub workers: u64,
        /// Stages of the campaign; 0 where it was measured as a whole.
        pub stages: u64,
        /// Total time, s.
        pub wall_s: f64,
        /// Share of the workers' time spent in stages.
        pub efficiency: f64,
        /// Data read from and written to the store, gigabytes.
        pub store_gb: f64,
        /// The same per time, megabytes per second.
        pub store_mb_s: f64,
        /// Largest cause of lost time.
        pub bound: String,
        /// Operations of the store: entries looked up, locked, unlocked, opened and filed; 0 where
        /// they are not counted.
        pub store_operations: u64,
        /// Stages whose lock another worker held.
        pub locks_lost: u64,
        /// Repeated requests of idle workers for stages that others compute.
        pub polls: u64,
    }
}
