//! What stays fixed during a solve: what holds the tendons, the loads, the motion and the history.

use nalgebra::Vector3;

use super::motion::Motion;
use crate::rod::params::hysteresis_law::HistoryState;
use crate::rod::params::loads::TipWrench;

/// What a tendon is held to during a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TendonConstraint {
    /// Taken in by this much from the straight rod, metres; pulls or goes slack.
    Length(f64),
    /// Held at this tension, N.
    Tension(f64),
}

/// What stays fixed during a solve.
pub(crate) struct SolveConditions<'a> {
    pub(crate) holds: &'a [TendonConstraint],
    /// For tendons held by length: whether it is taut.
    pub(crate) taut: &'a [bool],
    pub(crate) tip_load: &'a TipWrench,
    /// Share of the rod's constant loads, 1 but during continuation.
    pub(crate) load_share: f64,
    /// Acceleration of gravity, m/s² (the robot's, or a share of it during continuation).
    pub(crate) gravity_m_s2: Vector3<f64>,
    pub(crate) motion: &'a Motion,
    /// One a law and Gauss point.
    pub(crate) histories: &'a [Vec<HistoryState>],
    /// Whether slow history laws have come to rest.
    pub(crate) settled: bool,
}
