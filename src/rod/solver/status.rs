//! Outcome of a solve.

use std::fmt;

/// Outcome of a solve. Anything but [`SolveStatus::Converged`] means that the shape must not be
/// used as an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolveStatus {
    /// The equations hold within the tolerance.
    Converged,
    /// The iteration limit was reached, also with smaller load or time steps.
    NotConverged,
    /// The set of taut tendons did not converge.
    TendonSetUnsettled,
    /// Floating-point overflow: the loads far exceed what the rod can carry.
    NotFinite,
    /// The equations hold, but the discretisation error exceeds the tolerance: on the finest grid
    /// allowed (at rest), or on the grid of the motion (moving).
    UnderResolved,
    /// The equations hold for a shape in which cross-sections interpenetrate: the backbone or the
    /// path of a tendon has a length ≤ 0.
    Crushed,
    /// The equilibrium is unstable, and no stable one was found nearby.
    Unstable,
    /// The equilibrium is one about which oscillations grow (loads that turn with the rod). The rod
    /// is in it, and a motion may start there.
    Flutters,
    /// The command itself is not finite.
    BadCommand,
}

impl SolveStatus {
    /// All values.
    pub const ALL: [SolveStatus; 9] = [
        SolveStatus::Converged,
        SolveStatus::NotConverged,
        SolveStatus::TendonSetUnsettled,
        SolveStatus::NotFinite,
        SolveStatus::UnderResolved,
        SolveStatus::Crushed,
        SolveStatus::Unstable,
        SolveStatus::Flutters,
        SolveStatus::BadCommand,
    ];

    /// Whether the rod is in an equilibrium: one in which it stays, or about which oscillations
    /// grow.
    pub(crate) fn is_equilibrium(self) -> bool {
        matches!(self, SolveStatus::Converged | SolveStatus::Flutters)
    }

    /// This status where it is a failure, else `other`.
    pub(crate) fn or(self, other: SolveStatus) -> SolveStatus {
        if self == SolveStatus::Converged { other } else { self }
    }

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
            SolveStatus::Flutters => "flutters",
            SolveStatus::BadCommand => "bad_command",
        }
    }
}

impl fmt::Display for SolveStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
