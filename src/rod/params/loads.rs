//! Constant loads on a rod.

use nalgebra::Vector3;

/// A constant force and moment at the tip, fixed in the world frame (a dead load).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipWrench {
    /// Force at the tip in the world frame, N.
    pub force_n: Vector3<f64>,
    /// Moment at the tip in the world frame, N m.
    pub moment_nm: Vector3<f64>,
}

/// A force and a moment at one cross-section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLoad {
    /// Distance from the base along the relaxed rod, metres.
    pub position_m: f64,
    /// Force, N.
    pub force_n: Vector3<f64>,
    /// Moment, N m.
    pub moment_nm: Vector3<f64>,
    /// True: force and moment are given in the body axes and turn with the cross-section (a
    /// follower load). False: world frame.
    pub follows: bool,
}

/// A uniformly distributed force over part of the rod, world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineLoad {
    /// Where it begins, metres from the base along the relaxed rod.
    pub start_m: f64,
    /// Where it ends.
    pub end_m: f64,
    /// Force per relaxed length, N/m.
    pub force_n_m: Vector3<f64>,
}
