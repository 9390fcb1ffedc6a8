//! Time discretisation: within one implicit stage velocities and accelerations are affine in the unknown positions
//! (the semi-discretisation of Till et al. 2019, here for diagonally implicit Runge–Kutta stages).

use nalgebra::{Matrix3, Vector3};

use super::grid::Grid;
use super::section::Six;
use crate::math::rotation;

/// A mass fixed to the end of a cell.
#[derive(Clone, Debug)]
pub(super) struct EndMass {
    /// Which cell end.
    pub(super) end: usize,
    pub(super) mass_kg: f64,
    pub(super) inertia_kg_m2: Vector3<f64>,
}

/// How velocity follows from position in the current stage: v = rate·p + `*_v`, a = rate²·p + `*_a`.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// 1/(h γ), 1/s; zero at rest.
    pub(super) rate: f64,
    pub(super) node_v: Vec<Vector3<f64>>,
    pub(super) node_a: Vec<Vector3<f64>>,
    pub(super) end_v: Vec<Vector3<f64>>,
    pub(super) end_a: Vec<Vector3<f64>>,
    /// Strain rate = rate·strain + this.
    pub(super) strain_v: Vec<Six>,
    /// Orientation of the cell ends at the start of the step.
    pub(super) from_r: Vec<Matrix3<f64>>,
    /// Angular velocity (body) = rate·log(from_rᵀ r) + this.
    pub(super) spin_v: Vec<Vector3<f64>>,
    /// Angular acceleration (body) = rate²·log(from_rᵀ r) + this.
    pub(super) spin_a: Vec<Vector3<f64>>,
}

impl Motion {
    /// A rod at rest.
    pub(super) fn rest(grid: &Grid) -> Motion {
        let (nodes, ends) = (grid.nodes.len(), grid.boundaries_m.len());
        let zero = Vector3::zeros();
        Motion {
            rate: 0.0,
            node_v: vec![zero; nodes],
            node_a: vec![zero; nodes],
            end_v: vec![zero; ends],
            end_a: vec![zero; ends],
            strain_v: vec![[0.0; 6]; nodes],
            from_r: vec![Matrix3::identity(); ends],
            spin_v: vec![zero; ends],
            spin_a: vec![zero; ends],
        }
    }

    pub(super) fn node_velocity(&self, g: usize, p: &Vector3<f64>) -> Vector3<f64> {
        p * self.rate + self.node_v[g]
    }

    pub(super) fn node_acceleration(&self, g: usize, p: &Vector3<f64>) -> Vector3<f64> {
        p * (self.rate * self.rate) + self.node_a[g]
    }

    pub(super) fn end_velocity(&self, end: usize, p: &Vector3<f64>) -> Vector3<f64> {
        p * self.rate + self.end_v[end]
    }

    pub(super) fn end_acceleration(&self, end: usize, p: &Vector3<f64>) -> Vector3<f64> {
        p * (self.rate * self.rate) + self.end_a[end]
    }

    /// Body angular velocity and acceleration of a cell end.
    pub(super) fn spin(&self, end: usize, r: &Matrix3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let turn = rotation::log(&(self.from_r[end].transpose() * r));
        (turn * self.rate + self.spin_v[end], turn * (self.rate * self.rate) + self.spin_a[end])
    }

    /// Moment in the world frame that the rotary inertia of the masses at a cell end puts on the rod, N m.
    pub(super) fn spin_moment(&self, masses: &[EndMass], end: usize, r: &Matrix3<f64>) -> Vector3<f64> {
        let mut moment = Vector3::zeros();
        if self.rate == 0.0 {
            return moment;
        }
        for mass in masses.iter().filter(|mass| mass.end == end && mass.inertia_kg_m2 != Vector3::zeros()) {
            let (w, dw) = self.spin(end, r);
            let momentum = mass.inertia_kg_m2.component_mul(&w);
            moment -= r * (mass.inertia_kg_m2.component_mul(&dw) + w.cross(&momentum));
        }
        moment
    }
}
