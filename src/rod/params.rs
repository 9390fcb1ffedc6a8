//! What a rod is made of: everything the solver needs to know about one robot.

use std::sync::Arc;

use nalgebra::Vector3;

use super::memory::MomentLaw;
use super::scheme::Scheme;

/// Linear-elastic cross-section of the backbone and its rest shape over part of the length.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Where the span ends, metres from the base; it begins where the one before ends.
    pub end_m: f64,
    /// Bending stiffnesses E·I about the two principal axes, N m².
    pub bending_n_m2: [f64; 2],
    /// Angle of the first principal axis from x towards y, radians.
    pub principal_angle_rad: f64,
    /// Torsional stiffness G·J, N m².
    pub torsion_n_m2: f64,
    /// Shear stiffness G·A, N.
    pub shear_n: f64,
    /// Axial stiffness E·A, N.
    pub axial_n: f64,
    /// Curvature and twist when unloaded, rad/m (body axes).
    pub rest_curvature_rad_m: Vector3<f64>,
    /// Mass per length, kg/m.
    pub mass_kg_m: f64,
}

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

/// A tendon that runs parallel to the backbone through the disks and ends at one of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Tendon {
    /// Offset from the backbone in the cross-section, metres.
    pub offset_m: [f64; 2],
    /// Where it is anchored, metres from the base.
    pub end_m: f64,
    /// Displacement at home, metres: how much it is tightened before the first command.
    pub pretension_m: f64,
    /// Stretch of the whole tendon per tension at home, m/N.
    pub compliance_m_per_n: f64,
    /// Length over which it stretches at home, metres: what is pulled in no longer does. Infinite: the drive moves
    /// the whole tendon along, and its compliance stays.
    pub elastic_length_m: f64,
}

/// Constant loads that act on the rod besides gravity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipLoad {
    /// Force at the tip in the world frame, N.
    pub force_n: Vector3<f64>,
    /// Moment at the tip in the world frame, N m.
    pub moment_nm: Vector3<f64>,
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
    /// Moments with a memory.
    pub memory: Vec<Arc<dyn MomentLaw>>,
    /// Numerical resolution.
    pub resolution: Resolution,
}

/// Numerical resolution of the solver. The defaults keep statics of the paper's robot within a micrometre.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
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
    /// Displacement of the tip by which the discretisation in space may change a static solution, metres: beyond it the
    /// rod refines cells and polynomials by itself. Infinite: never.
    pub static_tolerance_m: f64,
    /// Largest time step, s.
    pub time_step_s: f64,
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
            static_tolerance_m: 1e-6,
            time_step_s: 0.05,
            scheme: Scheme::default(),
        }
    }
}

impl Resolution {
    /// Cells that an element needs at least: a Gauss point for each polynomial and two to spare.
    pub(super) fn least_cells(&self) -> usize {
        let bend_or_twist = self.bending_modes.max(self.torsion_modes);
        bend_or_twist.max(self.shear_modes).max(self.axial_modes).div_ceil(2) + 1
    }
}

impl Tendon {
    /// Stretch per tension once `pull_m` has been pulled in, m/N.
    pub(super) fn compliance_at(&self, pull_m: f64) -> f64 {
        self.compliance_m_per_n * (1.0 - pull_m / self.elastic_length_m)
    }
}

impl RodParams {
    /// Relaxed length of the rod, metres.
    pub fn length_m(&self) -> f64 {
        self.spans.last().map_or(0.0, |span| span.end_m)
    }

    /// The span that holds the point `position_m` from the base.
    pub fn span_at(&self, position_m: f64) -> &Span {
        self.spans.iter().find(|span| position_m < span.end_m).unwrap_or_else(|| &self.spans[self.spans.len() - 1])
    }

    /// Splits the spans so that one ends at `position_m`; effects that change part of the rod begin with this.
    pub fn split_at(&mut self, position_m: f64) {
        let Some(index) = self.spans.iter().position(|span| position_m < span.end_m) else { return };
        let start_m = if index == 0 { 0.0 } else { self.spans[index - 1].end_m };
        if position_m > start_m {
            let first = Span { end_m: position_m, ..self.spans[index].clone() };
            self.spans.insert(index, first);
        }
    }
}
