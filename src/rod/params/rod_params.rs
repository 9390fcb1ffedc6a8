//! What a rod is made of: everything the solver needs to know about one robot.

use std::sync::Arc;

use nalgebra::Vector3;

use super::scheme::Scheme;
use super::hysteresis_law::MomentLaw;
use super::span::Span;
use super::tendon::Tendon;

/// A section of the spine that shortens under axial force (paper, eq. 14 and Algorithm 1).
#[derive(Clone, Debug, PartialEq)]
pub struct CompressibleSection {
    /// Where it begins, metres from the base.
    pub start_m: f64,
    /// Its relaxed length, metres.
    pub length_m: f64,
    /// Shortening per compressive force, m/N.
    pub compliance_m_per_n: f64,
    /// Compressive force beyond which it shortens no more, N.
    pub saturation_n: f64,
}

/// A rigid disk, lumped at its centre.
#[derive(Clone, Debug, PartialEq)]
pub struct PointMass {
    /// Distance from the base along the relaxed rod, metres.
    pub position_m: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Moments of inertia about the body axes, kg m².
    pub inertia_kg_m2: Vector3<f64>,
}

/// A load at the tip that keeps its direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipLoad {
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

/// Everything the solver needs to know about one robot.
#[derive(Clone, Debug)]
pub struct RodParams {
    /// Cross-sections from base to tip; the last one ends at the tip.
    pub spans: Vec<Span>,
    /// Compressible sections, disjoint and in order.
    pub sections: Vec<CompressibleSection>,
    /// Lumped masses.
    pub masses: Vec<PointMass>,
    /// Tendons.
    pub tendons: Vec<Tendon>,
    /// Acceleration of gravity in the world frame, m/s².
    pub gravity_m_s2: Vector3<f64>,
    /// Base position in the world frame, metres.
    pub base_m: Vector3<f64>,
    /// Base orientation in the world frame as a rotation vector, radians.
    pub base_rotation_rad: Vector3<f64>,
    /// Viscous damping over stiffness of every strain (Kelvin–Voigt), s.
    pub damping_time_s: f64,
    /// Quadratic drag per length on each body axis, N s²/m³ (Till et al. 2019, eq. 5).
    pub drag_n_s2_m3: f64,
    /// Load at the tip.
    pub tip_load: TipLoad,
    /// Constant loads at other places.
    pub point_loads: Vec<PointLoad>,
    /// Constant loads over part of the rod.
    pub line_loads: Vec<LineLoad>,
    /// Moments with a memory.
    pub memory: Vec<Arc<dyn MomentLaw>>,
    /// Numerical resolution.
    pub resolution: Resolution,
}

/// Numerical resolution of the solver. The defaults keep statics of the paper's robot within a micrometre.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Resolution {
    /// Largest length of an integration cell (two Gauss points each), metres.
    pub cell_m: f64,
    /// Legendre polynomials for each bending moment along an element.
    pub bending_modes: usize,
    /// Legendre polynomials for the torsional moment.
    pub torsion_modes: usize,
    /// Legendre polynomials for each shear force.
    pub shear_modes: usize,
    /// Legendre polynomials for the axial force.
    pub axial_modes: usize,
    /// Whether polynomials also end where stiffness, rest shape, spine or lumped mass jump. The wrench is nearly smooth
    /// there, so that it pays only for the last micrometres.
    pub split_elements: bool,
    /// Whether cells go across jumps of stiffness, rest shape and spine: each Gauss point then stands for its share of what its
    /// cell holds. Fewer cells for a robot of many parts; wants an infinite `static_tolerance_m`, since refinement ends cells at
    /// jumps again.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub blended: bool,
    /// Displacement of the tip by which the discretisation in space may change a static solution, metres: beyond it the
    /// rod refines cells and polynomials by itself. Infinite: never.
    pub static_tolerance_m: f64,
    /// Largest time step, s.
    pub time_step_s: f64,
    /// Error that a time step may add to the position of any part of the rod, metres: steps are shortened to keep it.
    /// Infinite: all steps are of one length.
    pub motion_tolerance_m: f64,
    /// Time integration scheme.
    pub scheme: Scheme,
}

impl Default for Resolution {
    fn default() -> Self {
        Resolution {
            cell_m: 0.0125,
            bending_modes: 6,
            torsion_modes: 4,
            shear_modes: 4,
            axial_modes: 4,
            split_elements: false,
            blended: false,
            static_tolerance_m: 1e-6,
            time_step_s: 0.1,
            motion_tolerance_m: 1e-4,
            scheme: Scheme::default(),
        }
    }
}

impl Resolution {
    /// Cells that an element needs at least: a Gauss point for each polynomial.
    pub(crate) fn least_cells(&self) -> usize {
        let bend_or_twist = self.bending_modes.max(self.torsion_modes);
        bend_or_twist.max(self.shear_modes).max(self.axial_modes).div_ceil(2)
    }
}
