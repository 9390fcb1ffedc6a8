//! The rows of a population: robots that differ from repetition to repetition, and what holds on
//! how many of them.

use super::cell::CellLabel;
use crate::data::table_rows;

table_rows! {
    "robots.csv", key [seed, effect, parameter]:
    /// A parameter of an effect of one robot. A robot without a row is the model itself.
    pub struct RobotRow {
        /// Repetition, which has its own robot.
        pub seed: u64,
        /// Name of the effect.
        pub effect: String,
        /// Strength of the effect in usual sizes.
        pub strength: f64,
        /// Name of the parameter.
        pub parameter: String,
        /// Its value.
        pub value: f64,
        /// Its unit; `1` for a plain ratio.
        pub unit: String,
    }

    "robot_claims.csv", key [claim, training]:
    /// On how many robots a claim of the paper holds.
    pub struct RobotClaimRow {
        /// Short name.
        pub claim: String,
        /// The claim in words.
        pub statement: String,
        /// `paper` or `converged`.
        pub training: String,
        /// Robots with sufficient trials.
        pub robots: u64,
        /// Robots on which the claim holds.
        pub held: u64,
        /// Their share.
        pub share: f64,
        /// Wilson's 95 % interval of the share.
        pub low_95: f64,
        /// Wilson's 95 % interval of the share.
        pub high_95: f64,
    }

    "population.csv", key [training, policy, mode, gp_points, real_points]:
    /// The error of a policy over robots; that of a robot is its mean over targets.
    pub struct PopulationRow {
        /// `paper` or `converged`.
        pub training: String,
        flat cell: CellLabel,
        /// Robots with an error.
        pub robots: u64,
        /// 5th percentile over robots, metres.
        pub p05_m: f64,
        /// Lower quartile, metres.
        pub p25_m: f64,
        /// Median over robots, metres.
        pub median_m: f64,
        /// Upper quartile, metres.
        pub p75_m: f64,
        /// 95th percentile, metres.
        pub p95_m: f64,
        /// Largest over robots, metres.
        pub largest_m: f64,
        /// Repetition with the largest error.
        pub largest_seed: u64,
        /// Trials that failed, over all robots.
        pub failed: u64,
    }

    "attribution.csv", key [training, policy, mode, gp_points, real_points, effect]:
    /// What an effect adds to the error of a policy: robots that have the effect against robots
    /// that do not.
    pub struct AttributionRow {
        /// `paper` or `converged`.
        pub training: String,
        flat cell: CellLabel,
        /// Name of the effect.
        pub effect: String,
        /// Robots with the effect.
        pub robots_with: u64,
        /// Robots without it.
        pub robots_without: u64,
        /// Mean error with the effect minus mean error without it, metres.
        pub difference_m: f64,
        /// 95 % interval (Welch's t), metres; not corrected.
        pub low_95_m: f64,
        /// 95 % interval, metres.
        pub high_95_m: f64,
        /// Rank correlation of strength and error over robots with the effect (Spearman).
        pub rank_correlation: f64,
        /// p-value of Welch's t-test after Holm's correction over the effects.
        pub p_holm: f64,
    }
}
