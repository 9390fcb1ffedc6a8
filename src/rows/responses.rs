//! The rows of what tells controllers apart beside the error at the end: how fast, how directly,
//! and along a path in time.

use super::cell::{CellLabel, CellRow, CellValue, Outcome};
use crate::data::{TableDescription, TableRow, columns, table_rows};

columns! {
    /// One trial of fixed duration from rest at home to a target. Errors are those of the tip
    /// without tracking noise, where the robot is simulated; of a robot on a bench those of the
    /// measured tip.
    pub struct ResponseTrial {
        /// Number of the target in its draw; the same for every policy of a seed.
        pub target: u64,
        /// Distance of the target from the tip at home, metres.
        pub distance_m: f64,
        /// Minimum time at the speed limit of the drive from home to the last command, seconds;
        /// empty without a limit.
        pub limit_s: f64,
        /// Time after which the error stays within 5 mm, seconds; empty if it does not until the
        /// end.
        pub within_5mm_s: f64,
        /// The same for 3 mm, seconds.
        pub within_3mm_s: f64,
        /// The same for 2 mm, seconds.
        pub within_2mm_s: f64,
        /// Error after 1 s, metres.
        pub error_1s_m: f64,
        /// Error after 2 s, metres.
        pub error_2s_m: f64,
        /// Error after 5 s, metres.
        pub error_5s_m: f64,
        /// Mean error in the last second, metres.
        pub error_end_m: f64,
        /// Mean measured error in the last second, including tracking noise, metres.
        pub tracked_end_m: f64,
        /// Largest distance past the target, along the line from home, metres.
        pub overshoot_m: f64,
        /// Distance travelled by all tendons together, metres.
        pub tendon_travel_m: f64,
        /// `ok` or the named failure; a failed trial is counted and excluded from the means.
        pub status: Outcome,
    }

    /// One lap of the path in a given time: the target moves on with the clock and waits for
    /// nobody.
    pub struct PaceLap {
        /// Speed, as a multiple of that at which the lap takes `runs.pace.lap_s`.
        pub speed: f64,
        /// Duration of the lap, seconds.
        pub lap_s: f64,
        /// Root mean square of the distance from the moving target, metres; without tracking noise
        /// for a simulated robot.
        pub rms_m: f64,
        /// Largest distance, metres.
        pub largest_m: f64,
        /// Root mean square of the measured distance, metres.
        pub tracked_rms_m: f64,
        /// Distance travelled by all tendons together, metres.
        pub tendon_travel_m: f64,
        /// `ok` or the named failure.
        pub status: Outcome,
    }
}

/// A response with its cell.
pub type ResponseRow = CellRow<ResponseTrial>;

/// A lap with its cell.
pub type PaceRow = CellRow<PaceLap>;

/// The tables of cells of this file.
pub const CELL_TABLES: &[TableDescription] = &[ResponseRow::TABLE, PaceRow::TABLE];

impl CellValue for ResponseTrial {
    const ROW: &'static str = "ResponseRow";
    const FILE: &'static str = "responses.csv";
    const ABOUT: &'static str = "One trial of fixed duration from rest at home to a target.";
    const KEY: &'static [&'static str] = &["target"];

    fn status(&self) -> &Outcome {
        &self.status
    }
}

impl CellValue for PaceLap {
    const ROW: &'static str = "PaceRow";
    const FILE: &'static str = "paces.csv";
    const ABOUT: &'static str = "One lap of the path in a given time.";
    const KEY: &'static [&'static str] = &["speed"];

    fn status(&self) -> &Outcome {
        &self.status
    }
}

impl ResponseTrial {
    /// A trial that a failure before it made impossible.
    pub fn unmeasured(target: u64, status: Outcome) -> ResponseTrial {
        let none = f64::NAN;
        ResponseTrial {
            target,
            distance_m: none,
            limit_s: none,
            within_5mm_s: none,
            within_3mm_s: none,
            within_2mm_s: none,
            error_1s_m: none,
            error_2s_m: none,
            error_5s_m: none,
            error_end_m: none,
            tracked_end_m: none,
            overshoot_m: none,
            tendon_travel_m: none,
            status,
        }
    }
}

impl PaceLap {
    /// The same of a lap.
    pub fn unmeasured(speed: f64, lap_s: f64, status: Outcome) -> PaceLap {
        let none = f64::NAN;
        PaceLap {
            speed,
            lap_s,
            rms_m: none,
            largest_m: none,
            tracked_rms_m: none,
            tendon_travel_m: none,
            status,
        }
    }
}

table_rows! {
    "controllers.csv", key [training, policy, mode, gp_points, real_points]:
    /// Responses of one policy in one mode, over targets and seeds.
    pub struct ControllerRow {
        /// `paper` or `converged`.
        pub training: String,
        flat cell: CellLabel,
        /// Mean error at the end without tracking noise, metres.
        pub error_end_m: f64,
        /// Lower end of the 95 % interval of that mean over seeds, metres.
        pub low_95_m: f64,
        /// Its upper end, metres.
        pub high_95_m: f64,
        /// 95th percentile of the error at the end over all trials, metres.
        pub error_end_p95_m: f64,
        /// Mean measured error at the end, metres.
        pub tracked_end_m: f64,
        /// Median time to within 5 mm, with trials that do not reach it counted as the longest,
        /// seconds; empty if they are half of all trials.
        pub within_5mm_s: f64,
        /// The same for 3 mm, seconds.
        pub within_3mm_s: f64,
        /// The same for 2 mm, seconds.
        pub within_2mm_s: f64,
        /// Share of trials in which the error stays within 3 mm from some time on.
        pub within_3mm_share: f64,
        /// Median of the time to within 3 mm over the minimum time at the speed limit of the drive,
        /// with trials that do not reach it counted as the longest; empty if they are half of all
        /// trials.
        pub within_3mm_per_limit: f64,
        /// Mean error after 1 s, metres.
        pub error_1s_m: f64,
        /// Mean error after 2 s, metres.
        pub error_2s_m: f64,
        /// Mean error after 5 s, metres.
        pub error_5s_m: f64,
        /// Mean overshoot, metres.
        pub overshoot_m: f64,
        /// Mean distance travelled by all tendons together, metres.
        pub tendon_travel_m: f64,
        /// Seeds.
        pub seeds: u64,
        /// Trials without failure.
        pub trials: u64,
        /// Trials with one.
        pub failed: u64,
    }

    "points_needed.csv", key [training, policy, mode, wanted_m]:
    /// How many real points a policy needs for an error: from so many on, the mean error of the
    /// true tip at the end stays within it.
    pub struct PointsNeededRow {
        /// `paper` or `converged`.
        pub training: String,
        /// Name of the policy.
        pub policy: String,
        /// Name of the mode.
        pub mode: String,
        /// The error, metres.
        pub wanted_m: f64,
        /// Smallest tested number of points; empty if the error is larger with the largest number.
        pub points: f64,
        /// Largest tested number of points.
        pub most_points: u64,
    }
}
