//! `spinebench league answer`: answers for a network in a process of its own. `score` starts it.

use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::policies::{OutsidePolicy, answer_requests};

/// Answer requests of the protocol of policies for a network in an ONNX file.
#[derive(Args)]
pub(crate) struct AnswerCommand {
    /// The policy as JSON.
    policy: String,
}

impl AnswerCommand {
    pub(crate) fn execute(&self) -> CommandResult {
        let policy: OutsidePolicy =
            serde_json::from_str(&self.policy).map_err(CommandError::bad_input)?;
        answer_requests(&policy, std::io::stdin().lock(), std::io::stdout().lock())
            .map_err(CommandError::failed)
    }
}
