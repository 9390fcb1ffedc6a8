//! Time discretisation: within one implicit stage velocities and accelerations are affine in the
//! unknown positions (the semi-discretisation of Till et al. 2019, here for diagonally implicit
//! Runge–Kutta stages).

use nalgebra::{Matrix3, Vector3};

use super::material::Components;
use crate::math::rotation;
use crate::rod::discretisation::grid::Grid;

/// A mass fixed to the end of a cell.
#[derive(Clone, Debug)]
pub(crate) struct EndMass {
    /// Which cell end.
    pub(crate) end: usize,
    pub(crate) mass_kg: f64,
    pub(crate) inertia_kg_m2: Vector3<f64>,
}

/// Velocity and acceleration in the current stage: v = rate·p + `*_v`, a = rate²·p + `*_a`.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// 1/(h γ), 1/s; zero at rest.
    pub(crate) rate: f64,
    /// At the Gauss points.
    pub(crate) node_v: Vec<Vector3<f64>>,
    pub(crate) node_a: Vec<Vector3<f64>>,
    /// At the lumped masses.
    pub(crate) mass_v: Vec<Vector3<f64>>,
    pub(crate) mass_a: Vec<Vector3<f64>>,
    /// Strain rate = rate·strain + this.
    pub(crate) strain_v: Vec<Components>,
    /// Orientation of the masses at the start of the step.
    pub(crate) from_r: Vec<Matrix3<f64>>,
    /// Angular velocity (body) = rate·log(from_rᵀ r) + this; zero for masses without rotary
    /// inertia.
    pub(crate) spin_v: Vec<Vector3<f64>>,
    /// Angular acceleration (body) = rate²·log(from_rᵀ r) + this.
    pub(crate) spin_a: Vec<Vector3<f64>>,
}

impl Motion {
    /// A rod at rest.
    pub(crate) fn rest(grid: &Grid, masses: &[EndMass]) -> Motion {
        let (nodes, lumps) = (grid.nodes.len(), masses.len());
        let zero = Vector3::zeros();
        Motion {
            rate: 0.0,
            node_v: vec![zero; nodes],
            node_a: vec![zero; nodes],
            mass_v: vec![zero; lumps],
            mass_a: vec![zero; lumps],
            strain_v: vec![[0.0; 6]; nodes],
            from_r: vec![Matrix3::identity(); lumps],
            spin_v: vec![zero; lumps],
            spin_a: vec![zero; lumps],
        }
    }

    pub(crate) fn node_velocity(&self, g: usize, p: &Vector3<f64>) -> Vector3<f64> {
        p * self.rate + self.node_v[g]
    }

    pub(crate) fn node_acceleration(&self, g: usize, p: &Vector3<f64>) -> Vector3<f64> {
        p * (self.rate * self.rate) + self.node_a[g]
    }

    pub(crate) fn mass_velocity(&self, k: usize, p: &Vector3<f64>) -> Vector3<f64> {
        p * self.rate + self.mass_v[k]
    }

    pub(crate) fn mass_acceleration(&self, k: usize, p: &Vector3<f64>) -> Vector3<f64> {
        p * (self.rate * self.rate) + self.mass_a[k]
    }

    /// Body angular velocity and acceleration of mass `k` at orientation `r`.
    pub(crate) fn spin(&self, k: usize, r: &Matrix3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let turn = rotation::log(&(self.from_r[k].transpose() * r));
        (turn * self.rate + self.spin_v[k], turn * (self.rate * self.rate) + self.spin_a[k])
    }

    /// Moment in the world frame that the rotary inertia of mass `k` puts on the rod, N m.
    pub(crate) fn spin_moment(&self, mass: &EndMass, k: usize, r: &Matrix3<f64>) -> Vector3<f64> {
        if self.rate == 0.0 || !mass.turns() {
            return Vector3::zeros();
        }
        let (w, dw) = self.spin(k, r);
        // Euler's equations of a rigid body in body axes.
        let momentum = mass.inertia_kg_m2.component_mul(&w);
        -(r * (mass.inertia_kg_m2.component_mul(&dw) + w.cross(&momentum)))
    }
}

impl EndMass {
    /// Whether it has rotary inertia.
    pub(crate) fn turns(&self) -> bool {
        self.inertia_kg_m2 != Vector3::zeros()
    }
}
