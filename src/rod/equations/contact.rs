//! Contact with obstacles: points along the rod, the forces on them, and their derivative.
//!
//! A point of a cell lies on the cubic through the poses of the cell's ends (Hermite), so that a
//! force on it is a force and a moment on each end. A penetrated obstacle pushes back in proportion
//! (a penalty); a rigid one is so stiff that the penetration is rounding beside the length
//! (docs/method/rod.md). Friction is an elastic stretch of each point along the surface that slips where
//! its force exceeds the Coulomb limit (return mapping; Wriggers, Computational Contact Mechanics,
//! 2006, section 4.2).

use nalgebra::{Matrix3, Vector3};

use super::boundary_conditions::SolveConditions;
use super::jacobian::Derivative;
use super::rates::add_gram;
use super::shape::Shape;
use super::system::{RodEquations, Workspace};
use super::world_vectors::VectorDerivative;
use crate::rod::discretisation::grid::Grid;
use crate::rod::params::contact::ContactSurface;
use crate::rod::params::obstacle::Obstacle;
use crate::rod::params::rod_params::RodParams;

/// Points of contact in each cell, evenly spread; the last one lies at its end.
const POINTS_PER_CELL: usize = 8;
/// Stiffness of a rigid obstacle at rest, in units of E·I/L³: the force E·I/L², which bends the rod
/// by about its length, penetrates it by 10⁻⁵ lengths …
const RIGID_STIFFNESS_AT_REST: f64 = 1e5;
/// … and in motion, where a stiffer one makes contacts come and go within a step (docs/method/rod.md).
const RIGID_STIFFNESS_IN_MOTION: f64 = 3e3;

/// Penetration of an unloaded rod that is rounding, metres.
const HOME_PENETRATION_TOLERANCE_M: f64 = 1e-9;

/// A point of the rod that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactPoint {
    /// Its number from base to tip.
    number: usize,
    cell: usize,
    /// Weights of the positions of the cell's two ends, and of their tangents, metres.
    weights: [f64; 4],
    pub(crate) s_m: f64,
    radius_m: f64,
}

/// The contact of one point with one obstacle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub(crate) point: ContactPoint,
    obstacle: usize,
    /// Place of the point on the backbone, metres.
    pub(crate) place_m: Vector3<f64>,
    /// Force on the rod, N.
    pub(crate) force_n: Vector3<f64>,
    /// Moment on the cross-section, N m: friction acts on the surface.
    moment_nm: Vector3<f64>,
    /// − d force / d place, N/m.
    stiffness_n_m: Matrix3<f64>,
    /// Energy of the penetration, J.
    energy_j: f64,
    /// Elastic stretch along the surface, metres.
    stretch_m: Vector3<f64>,
}

/// An obstacle that reaches into the unloaded rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomePenetration {
    /// Its number, from 0.
    pub obstacle: usize,
    /// Where it reaches deepest, metres from the base along the rod.
    pub s_m: f64,
    /// How deep, metres.
    pub penetration_m: f64,
}

/// All contacts of a rod together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSum {
    /// Force on the rod, world frame, N.
    pub force_n: Vector3<f64>,
    /// Middle of the contacts along the relaxed rod, metres from the base, weighted by their
    /// forces.
    pub s_m: f64,
    /// The same of their places on the backbone, world frame, metres.
    pub place_m: Vector3<f64>,
}

impl ContactSum {
    /// Sums `touches`; `None` for none.
    pub(crate) fn of(touches: &[Touch]) -> Option<ContactSum> {
        // Norms, not the vector sum: opposite forces would cancel in the weights.
        let total_n: f64 = touches.iter().map(|touch| touch.force_n.norm()).sum();
        let share = |touch: &Touch| touch.force_n.norm() / total_n;
        (total_n > 0.0).then(|| ContactSum {
            force_n: touches.iter().map(|touch| touch.force_n).sum(),
            s_m: touches.iter().map(|touch| share(touch) * touch.point.s_m).sum(),
            place_m: touches.iter().map(|touch| touch.place_m * share(touch)).sum(),
        })
    }
}

/// What friction remembers: where the rod was, and the stretch of each point that touched.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactMemory {
    boundaries_m: Vec<f64>,
    ends: Vec<(Vector3<f64>, Vector3<f64>)>,
    stretches: Vec<Stretch>,
}

#[derive(Clone, Copy, Debug)]
struct Stretch {
    s_m: f64,
    obstacle: usize,
    stretch_m: Vector3<f64>,
}

impl ContactPoint {
    /// All points of a rod; none without obstacles.
    pub(crate) fn all(params: &RodParams, grid: &Grid) -> Vec<ContactPoint> {
        if params.contact.obstacles.is_empty() {
            return Vec::new();
        }
        let of_cell = |(cell, ends): (usize, &[f64])| {
            std::array::from_fn::<_, POINTS_PER_CELL, _>(|k| {
                let s_m = ends[0] + (ends[1] - ends[0]) * (k + 1) as f64 / POINTS_PER_CELL as f64;
                let number = cell * POINTS_PER_CELL + k;
                ContactPoint {
                    number,
                    ..ContactPoint::in_cell(cell, ends, s_m, params.contact.radius_at(s_m))
                }
            })
        };
        let all = grid.boundaries_m.windows(2).enumerate().flat_map(of_cell);
        // The foot of a tube would touch the table that its base stands on.
        all.filter(|point| point.s_m > point.radius_m).collect()
    }

    fn in_cell(cell: usize, ends_m: &[f64], s_m: f64, radius_m: f64) -> ContactPoint {
        let length_m = ends_m[1] - ends_m[0];
        ContactPoint {
            number: 0,
            cell,
            weights: hermite((s_m - ends_m[0]) / length_m, length_m),
            s_m,
            radius_m,
        }
    }

    fn place_m(&self, shape: &Shape) -> Vector3<f64> {
        let [a, b, c, d] = self.weights;
        let (p, r) = (&shape.end_p, &shape.end_r);
        p[self.cell] * a
            + p[self.cell + 1] * b
            + r[self.cell].column(2) * c
            + r[self.cell + 1].column(2) * d
    }
}

/// Cubic Hermite weights of the two positions and the two unit tangents at `share` of a cell.
fn hermite(share: f64, length_m: f64) -> [f64; 4] {
    let (t, u) = (share, 1.0 - share);
    [(1.0 + 2.0 * t) * u * u, t * t * (3.0 - 2.0 * t), length_m * t * u * u, -length_m * t * t * u]
}

impl Touch {
    /// The same contact on another grid of the rod.
    pub(crate) fn on_grid(&self, grid: &Grid) -> Touch {
        let ContactPoint { s_m, radius_m, .. } = self.point;
        let last = grid.cell_lengths_m.len() - 1;
        let cell = grid.boundaries_m[1..=last].partition_point(|&end| end < s_m);
        Touch {
            point: ContactPoint::in_cell(cell, &grid.boundaries_m[cell..cell + 2], s_m, radius_m),
            ..*self
        }
    }
}

impl ContactMemory {
    /// Ends a step: the rod is at `shape` and touches at `touches`.
    pub(crate) fn commit(
        &mut self,
        contact: &ContactSurface,
        grid: &Grid,
        shape: &Shape,
        touches: &[Touch],
    ) {
        if !contact.has_friction() {
            return;
        }
        self.boundaries_m.clone_from(&grid.boundaries_m);
        self.ends = shape
            .end_p
            .iter()
            .zip(&shape.end_r)
            .map(|(p, r)| (*p, r.column(2).into_owned()))
            .collect();
        let stretch = |touch: &Touch| Stretch {
            s_m: touch.point.s_m,
            obstacle: touch.obstacle,
            stretch_m: touch.stretch_m,
        };
        self.stretches = touches.iter().map(stretch).collect();
    }

    /// Where the point at `s_m` was; `None` without a memory.
    fn place_m(&self, s_m: f64) -> Option<Vector3<f64>> {
        let last = self.boundaries_m.len().checked_sub(2)?;
        let cell = self.boundaries_m[1..=last].partition_point(|&end| end < s_m);
        let (start_m, end_m) = (self.boundaries_m[cell], self.boundaries_m[cell + 1]);
        let [a, b, c, d] = hermite((s_m - start_m) / (end_m - start_m), end_m - start_m);
        let ((p, t), (q, u)) = (self.ends[cell], self.ends[cell + 1]);
        Some(p * a + q * b + t * c + u * d)
    }

    /// Stretch of the nearest point that touched this obstacle, metres.
    fn stretch_m(&self, s_m: f64, obstacle: usize) -> Vector3<f64> {
        let on_obstacle = self.stretches.iter().filter(|stretch| stretch.obstacle == obstacle);
        let nearest =
            on_obstacle.min_by(|a, b| (a.s_m - s_m).abs().total_cmp(&(b.s_m - s_m).abs()));
        // After a change of grid points shift by less than a cell; farther ones never touched.
        let spacing_m = self.boundaries_m.get(1).map_or(0.0, |end| end - self.boundaries_m[0]);
        nearest
            .filter(|near| (near.s_m - s_m).abs() < spacing_m)
            .map_or(Vector3::zeros(), |near| near.stretch_m)
    }
}

impl RodEquations {
    /// The force that bends the rod by about its length, E·I/L², N.
    pub(crate) fn bending_force_n(&self) -> f64 {
        let bending = self.sections.iter().map(|section| section.bending_n_m2).fold(0.0, f64::max);
        bending / self.params.length_m().powi(2)
    }

    /// Stiffness of an obstacle at each point, N/m.
    fn obstacle_stiffness_n_m(&self, obstacle: usize, conditions: &SolveConditions) -> f64 {
        let rigid =
            if conditions.at_rest { RIGID_STIFFNESS_AT_REST } else { RIGID_STIFFNESS_IN_MOTION };
        let rigid_n_m = || rigid * self.bending_force_n() / self.params.length_m();
        conditions.obstacle_share
            * self.params.contact.obstacles[obstacle].stiffness_n_m.unwrap_or_else(rigid_n_m)
    }

    /// The largest motion of a point of contact between two shapes, metres.
    pub(crate) fn contact_motion_m(&self, from: &Shape, to: &Shape) -> f64 {
        let moved = |point: &ContactPoint| (point.place_m(to) - point.place_m(from)).norm();
        self.contact_points.iter().map(moved).fold(0.0, f64::max)
    }

    /// Half the thickness of the thinnest obstacle together with that of the rod, metres.
    pub(crate) fn thinnest_obstacle_m(&self) -> f64 {
        let obstacles = self.params.contact.obstacles.iter();
        obstacles.map(|obstacle| obstacle.shape.radius_m()).fold(f64::INFINITY, f64::min)
            + self.params.contact.radius_m
    }

    /// The share of the stiffness of a rigid obstacle below which the force E·I/L² would push the
    /// rod through the thinnest one.
    pub(crate) fn softest_obstacle_share(&self) -> f64 {
        self.params.length_m() / (RIGID_STIFFNESS_AT_REST * self.thinnest_obstacle_m())
    }

    /// The largest force of an obstacle on one point of `shape`, N; negative where the rod touches
    /// nothing.
    pub(crate) fn hardest_contact_n(&self, conditions: &SolveConditions, shape: &Shape) -> f64 {
        let mut hardest_n = f64::NEG_INFINITY;
        for (index, obstacle) in self.params.contact.obstacles.iter().enumerate() {
            let stiffness_n_m = self.obstacle_stiffness_n_m(index, conditions);
            for point in &self.contact_points {
                let distance_m = obstacle.shape.surface(&point.place_m(shape)).distance_m;
                hardest_n = hardest_n.max(stiffness_n_m * (point.radius_m - distance_m));
            }
        }
        hardest_n
    }

    /// The deepest penetration of an obstacle by the unloaded rod; `None` where they are apart.
    pub(crate) fn home_penetration(&self) -> Option<HomePenetration> {
        let mut shape = self.workspace().shape;
        shape.update(&self.grid, &self.sections, &vec![0.0; self.grid.unknowns]);
        let of = |obstacle: usize| self.contact_points.iter().map(move |point| (obstacle, point));
        let all = (0..self.params.contact.obstacles.len()).flat_map(of).map(|(obstacle, point)| {
            let surface =
                self.params.contact.obstacles[obstacle].shape.surface(&point.place_m(&shape));
            HomePenetration {
                obstacle,
                s_m: point.s_m,
                penetration_m: point.radius_m - surface.distance_m,
            }
        });
        let deepest = all.max_by(|a, b| a.penetration_m.total_cmp(&b.penetration_m))?;
        (deepest.penetration_m > HOME_PENETRATION_TOLERANCE_M).then_some(deepest)
    }

    /// Updates the contacts for the shape in `workspace`.
    pub(crate) fn update_touches(&self, conditions: &SolveConditions, workspace: &mut Workspace) {
        workspace.touches.clear();
        if let Some(touches) = conditions.fixed_touches {
            workspace.touches.extend_from_slice(touches);
            return;
        }
        for obstacle in 0..self.params.contact.obstacles.len() {
            let stiffness_n_m = self.obstacle_stiffness_n_m(obstacle, conditions);
            for point in &self.contact_points {
                let touch =
                    self.touch(point, obstacle, stiffness_n_m, conditions, &workspace.shape);
                workspace.touches.extend(touch);
            }
        }
    }

    /// The contact of a point with an obstacle; `None` where they are apart.
    fn touch(
        &self,
        point: &ContactPoint,
        obstacle: usize,
        stiffness_n_m: f64,
        conditions: &SolveConditions,
        shape: &Shape,
    ) -> Option<Touch> {
        let place_m = point.place_m(shape);
        let Obstacle { shape: obstacle_shape, friction_coefficient, .. } =
            &self.params.contact.obstacles[obstacle];
        let surface = obstacle_shape.surface(&place_m);
        let penetration_m = point.radius_m - surface.distance_m;
        if penetration_m <= 0.0 {
            return None;
        }
        let (normal, normal_n) = (surface.normal, stiffness_n_m * penetration_m);
        let mut touch = Touch {
            point: *point,
            obstacle,
            place_m,
            force_n: normal * normal_n,
            moment_nm: Vector3::zeros(),
            // The second term turns the normal on a curved surface.
            stiffness_n_m: normal * normal.transpose() * stiffness_n_m
                - surface.curvature_1_m * normal_n,
            energy_j: 0.5 * normal_n * penetration_m,
            stretch_m: Vector3::zeros(),
        };
        let limit_n = friction_coefficient * normal_n;
        if let (true, Some(before_m)) =
            (limit_n > 0.0, conditions.contact_memory.place_m(point.s_m))
        {
            // Old stretches are turned into the present tangent plane.
            let tangential = Matrix3::identity() - normal * normal.transpose();
            let stretch_m = tangential
                * (conditions.contact_memory.stretch_m(point.s_m, obstacle) + place_m - before_m);
            // Return mapping: a trial stretch sticks within the Coulomb limit, else it slips.
            let trial_n = stiffness_n_m * stretch_m.norm();
            if trial_n <= limit_n {
                touch.stiffness_n_m += tangential * stiffness_n_m;
                touch.stretch_m = stretch_m;
            } else {
                let direction = stretch_m.normalize();
                let turning = tangential - direction * direction.transpose();
                // That the limit grows with the normal force is left out: K stays symmetric, and
                // the iteration contracts.
                touch.stiffness_n_m += turning * (limit_n / stretch_m.norm());
                touch.stretch_m = stretch_m * (limit_n / trial_n);
            }
            // Friction is as stiff as the penalty, so that sticking points hardly creep.
            let friction_n = -touch.stretch_m * stiffness_n_m;
            touch.force_n += friction_n;
            touch.moment_nm = (-normal * point.radius_m).cross(&friction_n);
        }
        Some(touch)
    }
}

/// Adds the forces of `touches` to the forces and moments on the ends of cells.
pub(crate) fn add_contact_loads(
    touches: &[Touch],
    shape: &Shape,
    end_f: &mut [Vector3<f64>],
    end_m: &mut [Vector3<f64>],
) {
    for Touch { point, force_n, moment_nm, .. } in touches {
        let [a, b, c, d] = point.weights;
        for (end, position, tangent) in [(point.cell, a, c), (point.cell + 1, b, d)] {
            end_f[end] += force_n * position;
            end_m[end] +=
                shape.end_r[end].column(2).cross(force_n) * tangent + moment_nm * position;
        }
    }
}

impl Derivative {
    /// Adds what the contact forces change with the shape. Their geometric part, as of dead loads,
    /// is in the loads.
    pub(super) fn add_contact(&mut self, system: &RodEquations, workspace: &Workspace) {
        let (n, size) = (system.grid.unknowns, system.size());
        let mut moved = VectorDerivative::zeros(system.grid.unknowns);
        for touch in &workspace.touches {
            let ContactPoint { cell, weights: [a, b, c, d], .. } = touch.point;
            moved.fill_zero();
            for (end, position, tangent) in [(cell, a, c), (cell + 1, b, d)] {
                let (turn, direction) = (
                    &self.variation.end_turn[end],
                    workspace.shape.end_r[end].column(2).into_owned(),
                );
                moved.add_scaled(&self.variation.end_move[end], position);
                moved.add_cross(turn, &direction, tangent);
                // The moment of the force about the end turns with the tangent: (δθ × t) × f = t
                // (δθ·f) − δθ (t·f).
                let force_n = touch.force_n * tangent;
                let turning =
                    Matrix3::identity() * direction.dot(&force_n) - force_n * direction.transpose();
                add_gram(&mut self.stiffness, n, size, turn, &turning);
            }
            add_gram(&mut self.stiffness, n, size, &moved, &touch.stiffness_n_m.transpose());
        }
    }
}

impl Workspace {
    /// Which points touch which obstacles, in order: point and obstacle.
    pub(crate) fn contact_set(&self) -> Vec<(usize, usize)> {
        self.touches.iter().map(|touch| (touch.point.number, touch.obstacle)).collect()
    }

    /// Energy of all penetrations, J.
    pub(crate) fn contact_energy_j(&self) -> f64 {
        self.touches.iter().map(|touch| touch.energy_j).sum()
    }
}
