//! The rows of what tells controllers apart beside the error at the end: how fast, how directly, and along a path in time.

use super::table_row::table_rows;

table_rows! {
    "responses.csv", key [seed, training, policy, mode, gp_points, real_points, target]:
    /// One trial of fixed duration from rest at home to a target. Errors are those of the tip without tracking noise, where
    /// the robot is simulated; of a robot on a bench those of the measured tip.
    pub struct ResponseRow {
        /// Repetition of the whole experiment, data and training included.
        pub seed: u64,
        /// `paper`: networks stopped at the paper's validation errors; `converged`: trained to convergence.
        pub training: String,
        /// Name of the policy.
        pub policy: String,
        /// Name of the mode.
        pub mode: String,
        /// Real points that the Gaussian process was fitted to (0 for policies without one).
        pub gp_points: u64,
        /// Real points that the network was trained on (0 for policies without one).
        pub real_points: u64,
        /// Number of the target in its draw; the same for every policy of a seed.
        pub target: u64,
        /// Distance of the target from the tip at home, metres.
        pub distance_m: f64,
        /// Time that the limit of the drive asks for to bring the tendons from home to the last command, seconds; empty
        /// without a limit.
        pub limit_s: f64,
        /// Time from which on the error stays within 5 mm, seconds; empty where it does not until the end.
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
        /// Mean error in the last second as it was measured, tracking noise included, metres.
        pub tracked_end_m: f64,
        /// Largest distance past the target, along the line from home, metres.
        pub overshoot_m: f64,
        /// Distance travelled by all tendons together, metres.
        pub tendon_travel_m: f64,
        /// `ok` or the named failure; a failed trial is counted and left out of the means.
        pub status: String,
    }

    "paces.csv", key [seed, training, policy, mode, gp_points, real_points, speed]:
    /// One lap of the path in a given time: the target moves on with the clock and waits for nobody.
    pub struct PaceRow {
        /// Repetition of the whole experiment.
        pub seed: u64,
        /// `paper` or `converged`.
        pub training: String,
        /// Name of the policy.
        pub policy: String,
        /// Name of the mode.
        pub mode: String,
        /// Real points that the Gaussian process was fitted to (0 for policies without one).
        pub gp_points: u64,
        /// Real points that the network was trained on (0 for policies without one).
        pub real_points: u64,
        /// Speed, as a multiple of that at which the lap takes `runs.pace.lap_s`.
        pub speed: f64,
        /// Duration of the lap, seconds.
        pub lap_s: f64,
        /// Root mean square of the distance from the moving target, without tracking noise where the robot is simulated,
        /// metres.
        pub rms_m: f64,
        /// Largest distance, metres.
        pub largest_m: f64,
        /// Root mean square of the distance as it was measured, metres.
        pub tracked_rms_m: f64,
        /// Distance travelled by all tendons together, metres.
        pub tendon_travel_m: f64,
        /// `ok` or the named failure.
        pub status: String,
    }

    "controllers.csv", key [training, policy, mode, gp_points, real_points]:
    /// Responses of one policy in one mode, over targets and seeds.
    pub struct ControllerRow {
        /// `paper` or `converged`.
        pub training: String,
        /// Name of the policy.
        pub policy: String,
        /// Name of the mode.
        pub mode: String,
        /// Real points of the Gaussian process.
        pub gp_points: u64,
        /// Real points of the network.
        pub real_points: u64,
        /// Mean error at the end without tracking noise, metres.
        pub error_end_m: f64,
        /// Lower end of the 95 % interval of that mean over seeds, metres.
        pub low_95_m: f64,
        /// Its upper end, metres.
        pub high_95_m: f64,
        /// 95th percentile of the error at the end over all trials, metres.
        pub error_end_p95_m: f64,
        /// Mean error at the end as it was measured, metres.
        pub tracked_end_m: f64,
        /// Median time to within 5 mm, trials that never get there counted as the longest, seconds; empty where that is half
        /// of them.
        pub within_5mm_s: f64,
        /// The same for 3 mm, seconds.
        pub within_3mm_s: f64,
        /// The same for 2 mm, seconds.
        pub within_2mm_s: f64,
        /// Share of trials that come to within 3 mm and stay.
        pub within_3mm_share: f64,
        /// Median of the time to within 3 mm over the time that the limit of the drive asks for, trials that never get there
        /// counted as the longest; empty where that is half of them.
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
    /// How many real points a policy needs for an error: from so many on, the mean error of the true tip at the end stays within
    /// it.
    pub struct PointsNeededRow {
        /// `paper` or `converged`.
        pub training: String,
        /// Name of the policy.
        pub policy: String,
        /// Name of the mode.
        pub mode: String,
        /// The error, metres.
        pub wanted_m: f64,
        /// Fewest points of those that were run; empty where the error is larger with the most points.
        pub points: f64,
        /// The most points that were run.
        pub most_points: u64,
    }
}

impl ResponseRow {
    /// A trial of which nothing has been measured, such as one that a failure before it made impossible; what labels the row
    /// is empty.
    pub fn unmeasured(target: u64, status: String) -> ResponseRow {
        let none = f64::NAN;
        ResponseRow {
            seed: 0,
            training: String::new(),
            policy: String::new(),
            mode: String::new(),
            gp_points: 0,
            real_points: 0,
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

impl PaceRow {
    /// The same of a lap.
    pub fn unmeasured(speed: f64, lap_s: f64, status: String) -> PaceRow {
        let none = f64::NAN;
        PaceRow {
            seed: 0,
            training: String::new(),
            policy: String::new(),
            mode: String::new(),
            gp_points: 0,
            real_points: 0,
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
