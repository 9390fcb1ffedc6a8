//! Fields along the rod, and its energy.

use nalgebra::{Matrix3, Vector3};

use super::rod::Rod;
use crate::rod::discretisation::grid::Grid;
use crate::rod::equations::boundary_conditions::TendonConstraint;

/// Kinematics and internal wrench of one cross-section: the fields of the paper's section III.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossSection {
    /// Distance from the base along the relaxed rod, metres.
    pub s_m: f64,
    /// Position p, metres.
    pub position_m: Vector3<f64>,
    /// Orientation R, columns are the body axes.
    pub rotation: Matrix3<f64>,
    /// Internal force n of the rod (without tendons), world frame, N.
    pub force_n: Vector3<f64>,
    /// Internal moment m of the rod (without tendons), world frame, N m.
    pub moment_nm: Vector3<f64>,
    /// Velocity q, body frame, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity ω, body frame, rad/s.
    pub angular_velocity_rad_s: Vector3<f64>,
}

/// Energy of the rod, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Of motion.
    pub kinetic_j: f64,
    /// Of bending, twist, shear and stretch, the compressible spine included.
    pub elastic_j: f64,
    /// Of weight, zero at the base.
    pub gravitational_j: f64,
}

impl Rod {
    /// The fields along the rod at the Gauss points.
    pub fn cross_sections(&self) -> Vec<CrossSection> {
        let (shape, rates) = (&self.state.shape, &self.state.rates);
        let turning = self.angular_velocities_rad_s();
        let section = |g: usize| {
            let r = shape.node_r[g];
            let wrench = shape.wrench[g];
            CrossSection {
                s_m: self.system.grid.nodes[g].position_m,
                position_m: shape.node_p[g],
                rotation: r,
                moment_nm: r * Vector3::from_row_slice(&wrench[..3]),
                force_n: r * Vector3::from_row_slice(&wrench[3..]),
                velocity_m_s: r.tr_mul(&rates.node_v[g]),
                angular_velocity_rad_s: r.tr_mul(&turning[g]),
            }
        };
        (0..self.system.grid.nodes.len()).map(section).collect()
    }

    /// World-frame angular velocities at the Gauss points, from the rates of curvature below each:
    /// ω(s) = ∫ R u_t.
    fn angular_velocities_rad_s(&self) -> Vec<Vector3<f64>> {
        let (shape, rates) = (&self.state.shape, &self.state.rates);
        let rate = |g: usize| shape.node_r[g] * Vector3::from_row_slice(&rates.strain_v[g][..3]);
        let mut below = Vector3::zeros();
        let mut all = Vec::with_capacity(shape.node_r.len());
        for (c, &cell_m) in self.system.grid.cell_lengths_m.iter().enumerate() {
            let both = [rate(2 * c), rate(2 * c + 1)];
            let partial = Grid::partial_weights(cell_m);
            all.extend(partial.map(|[first, second]| below + both[0] * first + both[1] * second));
            below += (both[0] + both[1]) * (0.5 * cell_m);
        }
        all
    }

    /// Energy now.
    pub fn energy(&self) -> Energy {
        let (shape, rates) = (&self.state.shape, &self.state.rates);
        let gravity = self.system.params.gravity_m_s2;
        let mut energy = Energy { kinetic_j: 0.0, elastic_j: 0.0, gravitational_j: 0.0 };
        for (g, node) in self.system.grid.nodes.iter().enumerate() {
            let section = &self.system.sections[g];
            let mass = section.mass_kg_m * node.weight_m;
            energy.kinetic_j += 0.5 * mass * rates.node_v[g].norm_squared();
            // Potential of weight: −m g·p.
            energy.gravitational_j -= mass * gravity.dot(&shape.node_p[g]);
            energy.elastic_j += node.weight_m * section.energy_j_m(&shape.wrench[g]);
        }
        for (k, mass) in self.system.masses.iter().enumerate() {
            energy.kinetic_j += 0.5 * mass.mass_kg * rates.mass_v[k].norm_squared();
            let spin = rates.spin[k];
            energy.kinetic_j += 0.5 * spin.dot(&mass.inertia_kg_m2.component_mul(&spin));
            energy.gravitational_j -= mass.mass_kg * gravity.dot(&shape.end_p[mass.end]);
        }
        self.add_tendon_energy(&mut energy);
        energy
    }

    /// Energy of a rest and of the loads on it, J: its minima are the stable rests. Moments that
    /// keep their direction and loads that turn with the rod have none.
    pub(crate) fn potential_energy_j(&self, constraints: &[TendonConstraint]) -> f64 {
        let energy = self.energy();
        let mut total =
            energy.elastic_j + energy.gravitational_j - self.tip_load.force_n.dot(&self.tip_m());
        let dead = self.system.constant_loads.points.iter().filter(|(_, load)| !load.follows);
        total -=
            dead.map(|(end, load)| load.force_n.dot(&self.state.shape.end_p[*end])).sum::<f64>();
        for (g, force) in self.system.constant_loads.line.iter().enumerate() {
            total -= self.system.grid.nodes[g].weight_m * force.dot(&self.state.shape.node_p[g]);
        }
        total += self.solver.workspace.contact_energy_j();
        for (constraint, length_m) in
            constraints.iter().zip(self.system.lengths_m(&self.state.shape))
        {
            if let TendonConstraint::Tension(tension_n) = constraint {
                // A drive of given tension is a hanging weight: it rises as the tendon shortens.
                total += tension_n * length_m;
            }
        }
        total
    }

    fn add_tendon_energy(&self, energy: &mut Energy) {
        for (tension, tendon) in self.tensions_n().iter().zip(&self.system.params.tendons) {
            energy.elastic_j += 0.5 * tendon.compliance_m_per_n * tension * tension;
        }
    }
}
