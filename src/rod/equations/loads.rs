//! External loads: weight, inertia, drag and tip load, summed from the tip towards the base to the
//! wrench that each cross-section carries.

use nalgebra::{Matrix3, Vector3};

use super::boundary_conditions::SolveConditions;
use super::contact::{Touch, add_contact_loads};
use super::material::Section;
use super::motion::EndMass;
use super::shape::Shape;
use crate::rod::discretisation::grid::Grid;
use crate::rod::params::loads::PointLoad;
use crate::rod::params::rod_params::RodParams;

/// Forces in the world frame and the resulting internal wrench.
#[derive(Clone, Debug)]
pub(crate) struct Loads {
    /// Force per length at the Gauss points, N/m.
    pub(crate) node_f: Vec<Vector3<f64>>,
    /// Force on each cell end, N.
    pub(crate) end_f: Vec<Vector3<f64>>,
    /// Moment on each cell end, N m.
    pub(crate) end_m: Vec<Vector3<f64>>,
    /// Force that the cross-section at each Gauss point carries, N.
    pub(crate) force: Vec<Vector3<f64>>,
    /// Moment about each Gauss point that its cross-section carries, N m.
    pub(crate) moment: Vec<Vector3<f64>>,
}

impl Loads {
    pub(crate) fn new(grid: &Grid) -> Loads {
        let (nodes, ends) = (grid.nodes.len(), grid.boundaries_m.len());
        let zero = Vector3::zeros();
        Loads {
            node_f: vec![zero; nodes],
            end_f: vec![zero; ends],
            end_m: vec![zero; ends],
            force: vec![zero; nodes],
            moment: vec![zero; nodes],
        }
    }

    /// Sums the loads on `shape` under the given conditions.
    #[inline(always)]
    pub(crate) fn update(&mut self, rod: &LoadedRod, shape: &Shape, conditions: &SolveConditions) {
        let (gravity, motion) = (conditions.loads.gravity_m_s2, conditions.motion);
        for (g, section) in rod.sections.iter().enumerate() {
            let mut f =
                section.mass_kg_m * (gravity - motion.node_acceleration(g, &shape.node_p[g]));
            if rod.params.drag_n_s2_m3 > 0.0 {
                // Quadratic drag on each body axis (Till et al. 2019, eq. 5).
                let body = shape.node_r[g].transpose() * motion.node_velocity(g, &shape.node_p[g]);
                // v|v| on each body axis keeps the sign of the velocity.
                f -= shape.node_r[g] * body.component_mul(&body.abs()) * rod.params.drag_n_s2_m3;
            }
            self.node_f[g] = f;
        }
        // Empty without line loads.
        let lines = self.node_f.iter_mut().zip(&rod.constant_loads.line);
        lines.for_each(|(f, line)| *f += line * conditions.loads.share);
        self.update_end_loads(rod, shape, conditions);
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        // From the free tip to the base: a cross-section carries all that lies beyond it.
        for (c, &cell_m) in rod.grid.cell_lengths_m.iter().enumerate().rev() {
            force += self.end_f[c + 1];
            moment += self.end_m[c + 1];
            (force, moment) = self.through_cell(c, cell_m, shape, force, moment);
        }
    }

    /// Forces and moments at the cell ends: lumped masses, point loads, and the load at the tip.
    #[inline(always)]
    fn update_end_loads(&mut self, rod: &LoadedRod, shape: &Shape, conditions: &SolveConditions) {
        let motion = conditions.motion;
        self.end_f.fill(Vector3::zeros());
        self.end_m.fill(Vector3::zeros());
        for (k, mass) in rod.masses.iter().enumerate() {
            let acceleration = motion.mass_acceleration(k, &shape.end_p[mass.end]);
            self.end_f[mass.end] += mass.mass_kg * (conditions.loads.gravity_m_s2 - acceleration);
            self.end_m[mass.end] += motion.spin_moment(mass, k, &shape.end_r[mass.end]);
        }
        for (end, load) in &rod.constant_loads.points {
            let (f, m) = load.in_world(&shape.end_r[*end], conditions.loads.share);
            self.end_f[*end] += f;
            self.end_m[*end] += m;
        }
        add_contact_loads(rod.touches, shape, &mut self.end_f, &mut self.end_m);
        let tip = self.end_f.len() - 1;
        self.end_f[tip] += conditions.loads.tip.force_n;
        self.end_m[tip] += conditions.loads.tip.moment_nm;
    }

    /// Transfers the wrench at the end of cell `c` (moment about that end) to its Gauss points and
    /// its start.
    #[inline(always)]
    fn through_cell(
        &mut self,
        c: usize,
        h: f64,
        shape: &Shape,
        force: Vector3<f64>,
        moment: Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let partial = Grid::partial_weights(h);
        let end = shape.end_p[c + 1];
        for row in 0..2 {
            let g = 2 * c + row;
            let p = shape.node_p[g];
            let (mut n, mut m) = (force, moment + (end - p).cross(&force));
            // Beyond the Gauss point: the whole cell less what lies before it.
            for (source, weight) in partial[row].iter().enumerate() {
                let f = self.node_f[2 * c + source] * (0.5 * h - weight);
                n += f;
                m += (shape.node_p[2 * c + source] - p).cross(&f);
            }
            self.force[g] = n;
            self.moment[g] = m;
        }
        let start = shape.end_p[c];
        let (mut n, mut m) = (force, moment + (end - start).cross(&force));
        for g in [2 * c, 2 * c + 1] {
            let f = self.node_f[g] * (0.5 * h);
            n += f;
            m += (shape.node_p[g] - start).cross(&f);
        }
        (n, m)
    }
}

/// The parts of a rod that carry loads.
pub(crate) struct LoadedRod<'a> {
    pub(crate) params: &'a RodParams,
    pub(crate) grid: &'a Grid,
    pub(crate) sections: &'a [Section],
    pub(crate) masses: &'a [EndMass],
    pub(crate) constant_loads: &'a ConstantLoads,
    pub(crate) touches: &'a [Touch],
}

/// Constant loads besides weight and the tip load, on the grid.
#[derive(Clone, Debug)]
pub(crate) struct ConstantLoads {
    /// Point loads with the cell end that carries each.
    pub(crate) points: Vec<(usize, PointLoad)>,
    /// Force per length at the Gauss points, N/m; empty when there is none.
    pub(crate) line: Vec<Vector3<f64>>,
}

impl ConstantLoads {
    pub(crate) fn new(params: &RodParams, grid: &Grid) -> ConstantLoads {
        let points = params
            .point_loads
            .iter()
            .map(|load| (grid.nearest_end(load.position_m), *load))
            .collect();
        let mut line = Vec::new();
        if !params.line_loads.is_empty() {
            line = grid.nodes.iter().map(|node| line_force(params, node.position_m)).collect();
        }
        ConstantLoads { points, line }
    }
}

/// Sum of the line loads at `position_m`, N/m.
fn line_force(params: &RodParams, position_m: f64) -> Vector3<f64> {
    let acting =
        params.line_loads.iter().filter(|load| (load.start_m..load.end_m).contains(&position_m));
    acting.map(|load| load.force_n_m).sum()
}

impl PointLoad {
    /// Force and moment in the world frame on a cross-section at orientation `r`, at `share` of
    /// their value.
    pub(crate) fn in_world(&self, r: &Matrix3<f64>, share: f64) -> (Vector3<f64>, Vector3<f64>) {
        if self.follows {
            (r * self.force_n * share, r * self.moment_nm * share)
        } else {
            (self.force_n * share, self.moment_nm * share)
        }
    }
}
