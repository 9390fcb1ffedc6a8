//! How a solve ended.

use std::fmt;

/// Outcome of a solve. Anything but [`SolveStatus::Converged`] means that the shape must not be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolveStatus {
    /// The equations hold within the tolerance.
    Converged,
    /// The iteration limit was reached, also with smaller load or time steps.
    NotConverged,
    /// The taut and slack tendons could not be settled.
    TendonSetUnsettled,
    /// Numbers overflowed: the loads are far beyond what the rod can carry.
    NotFinite,
    /// The equations hold, but the finest grid allowed does not settle the tip to the tolerance (at rest), or the grid
    /// of the motion is too coarse for this shape (moving).
    UnderResolved,
    /// The equations hold for a shape in which cross-sections pass through each other: the backbone, or the path of a
    /// tendon, is shortened to nothing or beyond.
    Crushed,
    /// The equilibrium found is one that the rod would leave at the slightest push, and no stable one was found nearby.
    Unstable,
    /// The command itself is not finite.
    BadCommand,
}

impl SolveStatus {
    /// Every status.
    pub const ALL: [SolveStatus; 8] = [
        SolveStatus::Converged,
        SolveStatus::NotConverged,
        SolveStatus::TendonSetUnsettled,
        SolveStatus::NotFinite,
        SolveStatus::UnderResolved,
        SolveStatus::Crushed,
        SolveStatus::Unstable,
        SolveStatus::BadCommand,
    ];

    /// Name used in recordings and tables.
    pub fn name(self) -> &'static str {
        match self {
            SolveStatus::Converged => "converged",
            SolveStatus::NotConverged => "not_converged",
            SolveStatus::TendonSetUnsettled => "tendon_set_unsettled",
            SolveStatus::NotFinite => "not_finite",
            SolveStatus::UnderResolved => "under_resolved",
            SolveStatus::Crushed => "crushed",
            SolveStatus::Unstable => "unstable",
            SolveStatus::BadCommand => "bad_command",
        }
    }
}

impl fmt::Display for SolveStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
