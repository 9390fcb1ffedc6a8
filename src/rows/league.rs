//! The rows of a league's board.

use crate::data::table_rows;

/// All families, or all modes or speeds.
pub const ALL: &str = "all";

/// The cell of answers, in place of a mode or speed.
pub const ANSWERS: &str = "answers";

/// What is measured where effects are named: a share of robots.
pub const SHARE_NOT_NAMED: &str = "share not named";

table_rows! {
    "board.csv", key [track, season, robots, cell, name]:
    /// One submission on the robots of one family, or on all of them.
    pub struct BoardRow {
        /// The track.
        pub track: String,
        /// The season; `development` for the development robots, `_sealed` behind it for sealed ones.
        pub season: String,
        /// Family of the robots, `all` (simulated ones), or `engine` and the name of one.
        pub robots: String,
        /// Mode or speed, or `all`: the mean over them.
        pub cell: String,
        /// Rank: 1, and one more for each submission whose interval lies wholly below.
        pub rank: u64,
        /// Name of the submission.
        pub name: String,
        /// Kind of the policy, or `answers`.
        pub kind: String,
        /// What is measured: `error over length`, or `share not named`.
        pub measure: String,
        /// Mean over robots of the error over the length of the robot; of the track `name` the share
        /// of robots whose effects are not named.
        pub error: f64,
        /// Lower end of its 95 % interval over robots.
        pub low_95: f64,
        /// Upper end.
        pub high_95: f64,
        /// The same error of a controller that knows the hidden effects; empty without a floor.
        pub floor: f64,
        /// Measured samples before the trials, and those of each robot.
        pub samples: u64,
        /// Median time of an answer of the policy, milliseconds; empty for policies of this program
        /// and for answers.
        pub tick_ms: f64,
        /// Number of robots.
        pub robot_count: u64,
        /// Number of trials.
        pub trials: u64,
        /// Trials that failed; each counts as an error of one length. Of the track `name`, robots whose
        /// effects are not named.
        pub failed: u64,
        /// Why, with numbers of trials. Of the track `name`: `false alarm` (nothing is missing),
        /// `missed detection` (nothing was named), `wrong isolation`.
        pub failures: String,
    }
}
