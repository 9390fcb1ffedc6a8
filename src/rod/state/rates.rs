//! Velocities and accelerations of a moving rod.

use nalgebra::Vector3;

use crate::rod::discretisation::grid::Grid;
use crate::rod::equations::material::Components;
use crate::rod::equations::motion::{EndMass, Motion};
use crate::rod::equations::shape::Shape;

/// Velocities and accelerations at the Gauss points and the lumped masses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rates {
    pub(crate) node_v: Vec<Vector3<f64>>,
    pub(crate) node_a: Vec<Vector3<f64>>,
    /// Of the lumped masses.
    pub(crate) mass_v: Vec<Vector3<f64>>,
    pub(crate) mass_a: Vec<Vector3<f64>>,
    pub(crate) strain_v: Vec<Components>,
    /// Body angular velocity and acceleration of the masses with rotary inertia; zero for the
    /// others.
    pub(crate) spin: Vec<Vector3<f64>>,
    pub(crate) spin_a: Vec<Vector3<f64>>,
}

impl Rates {
    pub(crate) fn zero(grid: &Grid, masses: &[EndMass]) -> Rates {
        let (nodes, lumps) = (grid.nodes.len(), masses.len());
        let zero = Vector3::zeros();
        Rates {
            node_v: vec![zero; nodes],
            node_a: vec![zero; nodes],
            mass_v: vec![zero; lumps],
            mass_a: vec![zero; lumps],
            strain_v: vec![[0.0; 6]; nodes],
            spin: vec![zero; lumps],
            spin_a: vec![zero; lumps],
        }
    }

    /// Copies `other` without allocating.
    pub(crate) fn copy_from(&mut self, other: &Rates) {
        self.node_v.clone_from(&other.node_v);
        self.node_a.clone_from(&other.node_a);
        self.mass_v.clone_from(&other.mass_v);
        self.mass_a.clone_from(&other.mass_a);
        self.strain_v.clone_from(&other.strain_v);
        self.spin.clone_from(&other.spin);
        self.spin_a.clone_from(&other.spin_a);
    }

    /// Reads the rates that `motion` gives to a solved shape.
    pub(crate) fn read(&mut self, motion: &Motion, masses: &[EndMass], shape: &Shape) {
        for (g, p) in shape.node_p.iter().enumerate() {
            self.node_v[g] = motion.node_velocity(g, p);
            self.node_a[g] = motion.node_acceleration(g, p);
            for c in 0..6 {
                self.strain_v[g][c] = shape.strain[g][c] * motion.rate + motion.strain_v[g][c];
            }
        }
        for (k, mass) in masses.iter().enumerate() {
            self.mass_v[k] = motion.mass_velocity(k, &shape.end_p[mass.end]);
            self.mass_a[k] = motion.mass_acceleration(k, &shape.end_p[mass.end]);
            if mass.turns() {
                (self.spin[k], self.spin_a[k]) = motion.spin(k, &shape.end_r[mass.end]);
            }
        }
    }
}
