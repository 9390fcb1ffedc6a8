//! Errors of a discovery.

use crate::base::BadOption;

/// Data that allow no answer. Messages name the column, what was found and what was expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DiscoveryError {
    /// Fewer items than the minimum.
    #[error("{what}: found {found}, expected at least {least}{why}")]
    TooFew {
        /// What is counted.
        what: &'static str,
        /// Number found.
        found: usize,
        /// Required minimum.
        least: usize,
        /// Reason for the minimum.
        why: &'static str,
    },
    /// A column is constant.
    #[error("{column}: found the same value in all {rows} rows, expected {expected}")]
    Constant {
        /// The columns.
        column: &'static str,
        /// Number of rows.
        rows: usize,
        /// What was expected.
        expected: &'static str,
    },
    /// The model cannot be simulated with the commands of this trial.
    #[error(
        "the model cannot be simulated with the commands of trial {0}: expected commands within \
         the robot's reach"
    )]
    CannotFollow(u64),
    /// The same for the baseline.
    #[error(transparent)]
    Baseline(Box<DiscoveryError>),
    /// An option is out of range.
    #[error(transparent)]
    Option(#[from] BadOption),
}
