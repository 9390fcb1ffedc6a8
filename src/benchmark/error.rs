//! Why there is no blind case.

use crate::base::BadOption;
use crate::tasks::TaskError;

/// A blind case cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BenchmarkError {
    /// The exploration that gives the commands failed.
    #[error(transparent)]
    Commands(#[from] TaskError),
    /// The model cannot follow its own commands.
    #[error("the model cannot follow the commands of its exploration")]
    Unplayable,
    /// The true robot cannot follow the commands, however often it was drawn.
    #[error("no robot with {what} can follow the commands; {tried} were drawn")]
    NoRobot {
        /// What was hidden in it.
        what: String,
        /// Robots that were drawn.
        tried: usize,
    },
    /// Nothing of the asked kind.
    #[error("{tried} candidates, and none of them is {group} the span of the catalogue: expected at least one")]
    NoneFound {
        /// `outside` or `inside`.
        group: &'static str,
        /// Candidates that were judged.
        tried: usize,
    },
    /// An uncertain number that is no parameter of the catalogue.
    #[error(transparent)]
    Option(#[from] BadOption),
}
