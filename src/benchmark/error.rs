//! Errors of the blind benchmark.

use crate::base::BadOption;
use crate::tasks::TaskError;

/// A blind case cannot be generated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BenchmarkError {
    /// The exploration that gives the commands failed.
    #[error(transparent)]
    Commands(#[from] TaskError),
    /// The model cannot be simulated with its own commands.
    #[error("the model has no solution for its exploration commands")]
    Unplayable,
    /// No drawn robot can be simulated with the commands.
    #[error("none of {tried} drawn robots with {what} has a solution for the commands")]
    NoRobot {
        /// Injected effect.
        what: String,
        /// Number of robots drawn.
        tried: usize,
    },
    /// The oracle found no candidate of the requested group.
    #[error(
        "none of {tried} candidates is {group} the span of the catalogue, expected at least one"
    )]
    NoneFound {
        /// `outside` or `inside`.
        group: &'static str,
        /// Number of candidates tested.
        tried: usize,
    },
    /// A prior on something that is no parameter of the catalogue.
    #[error(transparent)]
    Option(#[from] BadOption),
}
