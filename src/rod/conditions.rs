//! What stays fixed during a solve: what holds the tendons, the loads, the motion and the history.

use nalgebra::Vector3;

use super::memory::MemoryState;
use super::motion::Motion;
use super::params::TipLoad;

/// What a tendon is held to during a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Hold {
    /// Taken in by this much from the straight rod, metres; pulls or goes slack.
    Length(f64),
    /// Held at this tension, N.
    Tension(f64),
}

/// What stays fixed during a solve.
pub(super) struct Conditions<'a> {
    pub(super) holds: &'a [Hold],
    /// For tendons held by length: whether it is taut.
    pub(super) taut: &'a [bool],
    pub(super) tip_load: &'a TipLoad,
    /// Share of the rod's constant loads, 1 but during continuation.
    pub(super) load_share: f64,
    /// Acceleration of gravity, m/s² (the robot's, or a share of it during continuation).
    pub(super) gravity_m_s2: Vector3<f64>,
    pub(super) motion: &'a Motion,
    /// One a law and Gauss point.
    pub(super) memory: &'a [Vec<MemoryState>],
    /// Whether slow history laws have come to rest.
    pub(super) settled: bool,
}
