//! The state of a moving rod, and what one stage of a time step needs of it.

use nalgebra::{Matrix3, Vector3};

use super::grid::Grid;
use super::memory::MemoryState;
use super::motion::Motion;
use super::section::Six;
use super::shape::Shape;

/// Position, velocity and history of a rod at one instant.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// Polynomial coefficients, then tensions.
    pub(super) unknowns: Vec<f64>,
    pub(super) taut: Vec<bool>,
    pub(super) shape: Shape,
    pub(super) rates: Rates,
    pub(super) memory: Vec<Vec<MemoryState>>,
}

/// Velocities and accelerations of all that has them.
#[derive(Clone, Debug)]
pub(super) struct Rates {
    pub(super) node_v: Vec<Vector3<f64>>,
    pub(super) node_a: Vec<Vector3<f64>>,
    pub(super) end_v: Vec<Vector3<f64>>,
    pub(super) end_a: Vec<Vector3<f64>>,
    pub(super) strain_v: Vec<Six>,
    pub(super) spin: Vec<Vector3<f64>>,
    pub(super) spin_a: Vec<Vector3<f64>>,
}

impl Rates {
    pub(super) fn zero(grid: &Grid) -> Rates {
        let (nodes, ends) = (grid.nodes.len(), grid.boundaries_m.len());
        let zero = Vector3::zeros();
        Rates {
            node_v: vec![zero; nodes],
            node_a: vec![zero; nodes],
            end_v: vec![zero; ends],
            end_a: vec![zero; ends],
            strain_v: vec![[0.0; 6]; nodes],
            spin: vec![zero; ends],
            spin_a: vec![zero; ends],
        }
    }

    /// Reads the rates that `motion` gives to a solved shape.
    pub(super) fn read(&mut self, motion: &Motion, shape: &Shape) {
        for g in 0..self.node_v.len() {
            self.node_v[g] = motion.node_velocity(g, &shape.node_p[g]);
            self.node_a[g] = motion.node_acceleration(g, &shape.node_p[g]);
            for c in 0..6 {
                self.strain_v[g][c] = shape.strain[g][c] * motion.rate + motion.strain_v[g][c];
            }
        }
        for end in 0..self.end_v.len() {
            self.end_v[end] = motion.end_velocity(end, &shape.end_p[end]);
            self.end_a[end] = motion.end_acceleration(end, &shape.end_p[end]);
            (self.spin[end], self.spin_a[end]) = motion.spin(end, &shape.end_r[end]);
        }
    }
}

impl Motion {
    /// Prepares a stage: with step h, v = (p − p₀ − h Σ aᵢⱼ vⱼ)/(hγ) and a = (v − v₀ − h Σ aᵢⱼ aⱼ)/(hγ).
    /// `row` holds the coefficients of the earlier stages, whose rates are in `stages`.
    pub(super) fn prepare(&mut self, start: &State, row: &[f64], stages: &[Rates], gamma: f64, h: f64) {
        let rate = 1.0 / (h * gamma);
        self.rate = rate;
        let shares: Vec<f64> = row[..row.len() - 1].iter().map(|a| a / gamma).collect();
        let from = &start.rates;
        // Adds up the earlier stages' `v` and `a` of one point that started at p₀ with v₀.
        let history = |p: &Vector3<f64>, v: &Vector3<f64>, earlier: &dyn Fn(&Rates) -> [Vector3<f64>; 2]| {
            let (mut hist_v, mut hist_a) = (-p * rate, -v * rate);
            for (share, stage) in shares.iter().zip(stages) {
                let [stage_v, stage_a] = earlier(stage);
                hist_v -= stage_v * *share;
                hist_a -= stage_a * *share;
            }
            (hist_v, hist_v * rate + hist_a)
        };
        for g in 0..self.node_v.len() {
            (self.node_v[g], self.node_a[g]) =
                history(&start.shape.node_p[g], &from.node_v[g], &|s| [s.node_v[g], s.node_a[g]]);
            for c in 0..6 {
                let earlier: f64 = shares.iter().zip(stages).map(|(a, s)| a * s.strain_v[g][c]).sum();
                self.strain_v[g][c] = -start.shape.strain[g][c] * rate - earlier;
            }
        }
        for end in 0..self.end_v.len() {
            (self.end_v[end], self.end_a[end]) =
                history(&start.shape.end_p[end], &from.end_v[end], &|s| [s.end_v[end], s.end_a[end]]);
            (self.spin_v[end], self.spin_a[end]) =
                history(&Vector3::zeros(), &from.spin[end], &|s| [s.spin[end], s.spin_a[end]]);
        }
        self.from_r.clone_from_slice(&start.shape.end_r);
    }
}

/// What a cross-section of the rod does and carries: the fields of the paper's section III.
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
