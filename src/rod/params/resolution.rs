//! Numerical resolution of the solver.

use super::scheme::Scheme;

/// Numerical resolution of the solver. The defaults keep statics of the paper's robot within a
/// micrometre.
#[derive(
    Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
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
    /// Whether polynomials also end at jumps of stiffness, rest shape, spine and lumped mass. The
    /// wrench is nearly smooth there: this affects only the last micrometres.
    pub split_elements: bool,
    /// Whether cells span jumps of stiffness, rest shape and spine, with homogenised properties at
    /// their Gauss points. This needs fewer cells for a robot of many parts. It requires an
    /// infinite `static_tolerance_m`, since refined grids end cells at jumps.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub blended: bool,
    /// Allowed tip error of a static solution due to the spatial discretisation, metres. The rod
    /// refines its grid when the estimate exceeds it. Infinite: no refinement.
    pub static_tolerance_m: f64,
    /// Largest time step, s.
    pub time_step_s: f64,
    /// Allowed error per time step in the position of any part of the rod, metres. Steps are
    /// shortened to keep it. Infinite: constant step length.
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
    /// Least number of cells per element: one Gauss point for each polynomial.
    pub(crate) fn min_cells(&self) -> usize {
        let bend_or_twist = self.bending_modes.max(self.torsion_modes);
        bend_or_twist.max(self.shear_modes).max(self.axial_modes).div_ceil(2)
    }
}
