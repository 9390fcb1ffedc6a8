//! Why a calibration is refused.

use crate::base::BadOption;

/// Why a calibration is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// The model has no such number; the second text proposes another.
    #[error("`{name}`: the model has no number at this path{suggestion}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What may have been meant, as the end of a sentence.
        suggestion: String,
    },
    /// The path leads to something that is no real number.
    #[error("`{name}`: found {found}, expected the path of a number")]
    NoNumber {
        /// What was asked for.
        name: String,
        /// What stands there.
        found: String,
    },
    /// The start or the deviation behind a path is no number.
    #[error("`{entry}`: found `{found}`, expected {expected}")]
    Entry {
        /// The entry of `--fit`.
        entry: String,
        /// The part that is wrong.
        found: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A number is asked for twice.
    #[error("found `{0}` twice, expected each number once")]
    Repeated(String),
    /// Changing the number changes nothing in this model.
    #[error("`{name}`: no effect in this model{reason}")]
    Idle {
        /// Its path.
        name: String,
        /// Why, as the end of a sentence.
        reason: String,
    },
    /// A value of the model is out of range.
    #[error(transparent)]
    Option(#[from] BadOption),
    /// More numbers than data.
    #[error("{what}: found {available}, expected at least {required}")]
    TooFew {
        /// What was counted.
        what: &'static str,
        /// Least number.
        required: usize,
        /// Number found.
        available: usize,
    },
    /// The recording has no tip and no other tracked point of the model.
    #[error("found no tracked tip or point in the recording, expected at least one row with one")]
    NothingTracked,
    /// The model cannot follow the commands.
    #[error(
        "the model cannot simulate these commands: {failed} of {rows} rows have no solution, first \
         trial {trial}, {time_s} s"
    )]
    NotSimulated {
        /// Rows without a solution.
        failed: usize,
        /// Compared rows.
        rows: usize,
        /// Trial of the first one.
        trial: u64,
        /// Its time, s.
        time_s: f64,
    },
    /// Nothing of the recording fits the names to hold out, or nothing remains.
    #[error("{0}")]
    HoldOut(String),
}
