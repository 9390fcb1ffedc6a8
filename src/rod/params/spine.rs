//! Compressible sections of the spine and lumped masses.

use nalgebra::Vector3;

/// A section of the spine that shortens under axial force (paper, eq. 14 and Algorithm 1).
#[derive(Clone, Debug, PartialEq)]
pub struct CompressibleSection {
    /// Where it begins, metres from the base.
    pub start_m: f64,
    /// Its relaxed length, metres.
    pub length_m: f64,
    /// Shortening per compressive force, m/N.
    pub compliance_m_per_n: f64,
    /// Compressive force beyond which it shortens no further, N.
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
