//! How a solve ended.

use std::fmt;

/// Outcome of a solve. Anything but [`Status::Converged`] means that the shape must not be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The equations hold within the tolerance.
    Converged,
    /// The iteration limit was reached, also with smaller load or time steps.
    NotConverged,
    /// The taut and slack tendons could not be settled.
    TendonSetUnsettled,
    /// Numbers overflowed: the loads are far beyond what the rod can carry.
    NotFinite,
    /// The command itself is not finite.
    BadCommand,
}

impl Status {
    /// Name used in recordings and tables.
    pub fn name(self) -> &'static str {
        match self {
            Status::Converged => "converged",
            Status::NotConverged => "not_converged",
            Status::TendonSetUnsettled => "tendon_set_unsettled",
            Status::NotFinite => "not_finite",
            Status::BadCommand => "bad_command",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
