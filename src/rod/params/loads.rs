//! Constant loads on a rod.

use nalgebra::Vector3;

/// A load at the tip that keeps its direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipWrench {
    /// Force at the tip in the world frame, N.
    pub force_n: Vector3<f64>,
    /// Moment at the tip in the world frame, N m.
    pub moment_nm: Vector3<f64>,
}

/// A force and a moment at one place of the rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLoad {
    /// Distance from the base along the relaxed rod, metres.
    pub position_m: f64,
    /// Force, N.
    pub force_n: Vector3<f64>,
    /// Moment, N m.
    pub moment_nm: Vector3<f64>,
    /// Given in the body axes of the cross-section, and turning with it (a follower load), instead of the world's.
    pub follows: bool,
}

/// A force spread evenly over part of the rod, in the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineLoad {
    /// Where it begins, metres from the base along the relaxed rod.
    pub start_m: f64,
    /// Where it ends.
    pub end_m: f64,
    /// Force per relaxed length, N/m.
    pub force_n_m: Vector3<f64>,
}
