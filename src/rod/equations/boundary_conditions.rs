//! Boundary conditions of a solve: tendon constraints, loads, motion and history.

use nalgebra::Vector3;

use super::contact::{ContactMemory, Touch};
use super::motion::Motion;
use super::tendon_friction::TendonSliding;
use crate::rod::params::hysteresis_law::HistoryState;
use crate::rod::params::loads::TipWrench;

/// Constraint on one tendon during a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TendonConstraint {
    /// Displacement from the straight rod, metres; the tendon is taut or slack.
    Length(f64),
    /// Prescribed tension, N.
    Tension(f64),
}

/// Loads of one solve, obstacles left out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AppliedLoads {
    pub(crate) tip: TipWrench,
    /// Share of the rod's constant loads; below 1 only during continuation.
    pub(crate) share: f64,
    /// Acceleration of gravity, m/s² (the robot's, or a share of it during continuation).
    pub(crate) gravity_m_s2: Vector3<f64>,
}

/// Data that stay fixed during a solve.
pub(crate) struct SolveConditions<'a> {
    pub(crate) constraints: &'a [TendonConstraint],
    /// For tendons held by length: whether it is taut.
    pub(crate) taut: &'a [bool],
    pub(crate) loads: &'a AppliedLoads,
    pub(crate) motion: &'a Motion,
    /// Histories, indexed by moment law and Gauss point.
    pub(crate) histories: &'a [Vec<HistoryState>],
    /// Sliding of the tendons at the start of the step.
    pub(crate) sliding: &'a [TendonSliding],
    /// What the friction of contacts remembers at the start of the step.
    pub(crate) contact_memory: &'a ContactMemory,
    /// Contacts that do not change with the shape; `None`: as the shape makes them.
    pub(crate) fixed_touches: Option<&'a [Touch]>,
    /// Share of the stiffness of obstacles; below 1 only on the way to an equilibrium.
    pub(crate) obstacle_share: f64,
    /// Whether the rod is at rest: rate-dependent moment laws relax …
    pub(crate) at_rest: bool,
    /// … for so many seconds.
    pub(crate) rested_s: f64,
}
