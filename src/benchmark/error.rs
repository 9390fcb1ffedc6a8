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
    #[error("the model cannot follow the commands of its exploration")]
    Unplayable,
    /// No drawn robot can be simulated with the commands.
    #[error("no robot with {what} can follow the commands; {tried} were drawn")]
    NoRobot {
        /// Injected effect.
        what: String,
        /// Number of robots drawn.
        tried: usize,
    },
    /// The oracle found no candidate of the requested group.
    #[error(
        "{tried} candidates, and none of them is {group} the span of the catalogue: expected at \
         least one"
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
