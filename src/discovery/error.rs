//! Why a discovery cannot be made.

use crate::base::BadOption;

/// Data that allow no answer. The messages name the column, what was found and what was expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DiscoveryError {
    /// Less than the smallest recording that can be rescored.
    #[error("{what}: found {found}, expected at least {least}{why}")]
    TooFew {
        /// Of what.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        least: usize,
        /// What they are for.
        why: &'static str,
    },
    /// A column that never changes.
    #[error("{column}: found the same value in all {rows} rows, expected {expected}")]
    Constant {
        /// The columns.
        column: &'static str,
        /// Number of rows.
        rows: usize,
        /// What was expected.
        expected: &'static str,
    },
    /// The model cannot follow the commands.
    #[error(
        "the model cannot be simulated with the commands of trial {0}: expected commands within the robot's \
         reach"
    )]
    CannotFollow(u64),
    /// The same, for the baseline.
    #[error(transparent)]
    Baseline(Box<DiscoveryError>),
    /// A setting.
    #[error(transparent)]
    Option(#[from] BadOption),
}
