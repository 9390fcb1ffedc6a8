//! Why a stage has no result.

use serde::{Deserialize, Serialize};

/// Why a stage has no result. It becomes the status of the rows that needed it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{stage}: {status}")]
pub struct Failure {
    /// Name of the stage that failed.
    pub stage: String,
    /// Message of the part that failed.
    pub status: String,
}
