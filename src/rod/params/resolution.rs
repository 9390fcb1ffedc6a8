//! Numerical resolution of the solver.

use super::scheme::Scheme;

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
