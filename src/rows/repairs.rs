//! The rows of repairs: a robot changes and nobody announces it.

use super::cell::{CellLabel, Outcome};
use crate::data::table_rows;

table_rows! {
    "monitors.csv", key [seed, training], failed [|row| !row.status.is_ok()]:
    /// The monitor of one repetition, tried on the unchanged robot.
    pub struct MonitorRow {
        /// Repetition of the whole experiment, including data and training.
        pub seed: u64,
        /// `paper` or `converged`: training of the networks of the working policy.
        pub training: String,
        /// Log-likelihood ratio above which the monitor raises an alarm.
        pub threshold: f64,
        /// Operating time of the unchanged robot in which alarms were counted, seconds.
        pub watched_s: f64,
        /// Alarms in that time.
        pub false_alarms: u64,
        /// `ok` or the named failure.
        pub status: Outcome,
    }

    "identifications.csv", key [seed], failed [|row| !row.status.is_ok()]:
    /// What the model lacked of the robot as it was built.
    pub struct IdentificationRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// Rows that were recorded.
        pub samples: u64,
        /// The verdict of the discovery, or `failed` with the reason.
        pub verdict: String,
        /// Lines added to the model; empty for none.
        pub named: String,
        /// Mean distance of the targets from the nearest equilibrium position of the tip of this
        /// robot under bending, metres.
        pub nearest_m: f64,
        /// Rms tip error of held-out trials without these lines, metres.
        pub gap_before_m: f64,
        /// The same with them, metres.
        pub gap_after_m: f64,
        /// Rms distance of the measured from the true tip by noise alone, metres.
        pub noise_floor_m: f64,
        /// `ok` or the named failure.
        pub status: Outcome,
    }

    "repairs.csv", key [seed, training, change], failed [|row| !row.status.is_ok()]:
    /// One change of the robot: how it was noticed, and what it was told to be.
    pub struct RepairRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// `paper` or `converged`: training of the networks of the working policy.
        pub training: String,
        /// Name of the change.
        pub change: String,
        /// The change: effects added to the robot.
        pub truth: String,
        /// Operating time from the change to the alarm, seconds; empty without an alarm.
        pub alarm_s: f64,
        /// Rows recorded after the alarm.
        pub samples: u64,
        /// The verdict of the discovery, or `failed` with the reason.
        pub verdict: String,
        /// Lines added to the model; empty for none.
        pub named: String,
        /// Mean distance of the targets from the nearest equilibrium position of the tip of this
        /// robot under bending, metres.
        pub nearest_m: f64,
        /// Rms tip error of held-out trials without these lines, metres.
        pub gap_before_m: f64,
        /// The same with them, metres.
        pub gap_after_m: f64,
        /// Rms distance of the measured from the true tip by noise alone, metres.
        pub noise_floor_m: f64,
        /// `ok` or the named failure.
        pub status: Outcome,
    }

    "repair_trials.csv", key [seed, training, change, variant, policy, mode, gp_points, real_points, target], failed [|row| !row.status.is_ok()]:
    /// One goal-reaching trial before a change, after it, or mended.
    pub struct RepairTrialRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// `paper` or `converged`.
        pub training: String,
        /// Name of the change.
        pub change: String,
        /// `before`: the unchanged robot; `changed`: the changed robot with the unchanged
        /// controller; `repaired`: networks trained further with the model that contains the named
        /// lines; `moved_points`: unchanged networks, and the real points of the error model moved
        /// by the predicted effect of the named lines; `new_points`: an error model of new real
        /// points of the changed robot; `new_real`: a network of new real data of the changed
        /// robot.
        pub variant: String,
        flat cell: CellLabel,
        /// Number of the target in its draw; the same for every policy of a seed.
        pub target: u64,
        /// Distance of the last measured tip from the target, metres.
        pub error_m: f64,
        /// Control steps taken.
        pub steps: u64,
        /// Whether the policy settled before the step limit.
        pub settled: bool,
        /// `ok` or the named failure; a failed trial is counted and excluded from the means.
        pub status: Outcome,
    }

    "repair_summary.csv", key [training, change, variant, policy, mode, gp_points, real_points]:
    /// Goal reaching of one policy in one mode, over targets and repetitions.
    pub struct RepairSummaryRow {
        /// `paper` or `converged`.
        pub training: String,
        /// Name of the change.
        pub change: String,
        /// As in `repair_trials.csv`.
        pub variant: String,
        flat cell: CellLabel,
        /// Number of measurements of the changed robot used.
        pub new_samples: u64,
        /// Mean error, metres.
        pub mean_m: f64,
        /// Lower end of its 95 % interval over repetitions, metres.
        pub low_95_m: f64,
        /// Its upper end, metres.
        pub high_95_m: f64,
        /// Standard deviation of the error over all trials, metres.
        pub sd_m: f64,
        /// Mean error over that before the change.
        pub of_before: f64,
        /// Repetitions.
        pub seeds: u64,
        /// Trials without failure.
        pub trials: u64,
        /// Trials with one.
        pub failed: u64,
    }
}
