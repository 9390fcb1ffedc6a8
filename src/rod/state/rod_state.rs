//! The state of a moving rod, and what one stage of a time step needs of it.

use nalgebra::{Matrix3, Vector3};

use crate::rod::discretisation::grid::Grid;
use crate::rod::params::hysteresis_law::MemoryState;
use crate::rod::equations::material::Six;
use crate::rod::equations::motion::{EndMass, Motion};
use crate::rod::equations::shape::Shape;

/// Position, velocity and history of a rod at one instant.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Polynomial coefficients, then tensions.
    pub(crate) unknowns: Vec<f64>,
    pub(crate) taut: Vec<bool>,
    pub(crate) shape: Shape,
    pub(crate) rates: Rates,
    pub(crate) memory: Vec<Vec<MemoryState>>,
}

impl State {
    /// A state of nothing, to hold a place.
    pub(crate) fn empty() -> State {
        State {
            unknowns: Vec::new(),
            taut: Vec::new(),
            shape: Shape::default(),
            rates: Rates::default(),
            memory: Vec::new(),
        }
    }

    /// Becomes a copy of `other` without allocating.
    pub(crate) fn copy_from(&mut self, other: &State) {
        self.unknowns.clone_from(&other.unknowns);
        self.taut.clone_from(&other.taut);
        self.shape.copy_from(&other.shape);
        self.rates.copy_from(&other.rates);
        self.memory.clone_from(&other.memory);
    }
}

/// Velocities and accelerations of all that has them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rates {
    pub(crate) node_v: Vec<Vector3<f64>>,
    pub(crate) node_a: Vec<Vector3<f64>>,
    /// Of the lumped masses.
    pub(crate) mass_v: Vec<Vector3<f64>>,
    pub(crate) mass_a: Vec<Vector3<f64>>,
    pub(crate) strain_v: Vec<Six>,
    /// Body angular velocity and acceleration of the masses with rotary inertia; zero for the others.
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

    /// Becomes a copy of `other` without allocating.
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

/// Rates that a stage of a step starts from: with step h, v = (p − p₀ − h Σ aᵢⱼ vⱼ)/(hγ) and
/// a = (v − v₀ − h Σ aᵢⱼ aⱼ)/(hγ).
struct History<'a> {
    rate: f64,
    /// aᵢⱼ/γ with the earlier stages' rates.
    earlier: &'a [(f64, &'a Rates)],
}

impl History<'_> {
    /// What p₀, v₀ and the earlier stages contribute to v and a of one point.
    #[inline]
    fn of(
        &self,
        p: &Vector3<f64>,
        v: &Vector3<f64>,
        stage: impl Fn(&Rates) -> (Vector3<f64>, Vector3<f64>),
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (mut hist_v, mut hist_a) = (-p * self.rate, -v * self.rate);
        for (share, rates) in self.earlier {
            let (stage_v, stage_a) = stage(rates);
            hist_v -= stage_v * *share;
            hist_a -= stage_a * *share;
        }
        (hist_v, hist_v * self.rate + hist_a)
    }
}

impl Motion {
    /// Prepares a stage of a step of `h` seconds. `row` holds the coefficients of the earlier stages, whose rates are
    /// in `stages`, and then γ.
    pub(crate) fn prepare(&mut self, start: &State, masses: &[EndMass], row: &[f64], stages: &[Rates], h: f64) {
        let gamma = row[row.len() - 1];
        let rate = 1.0 / (h * gamma);
        self.rate = rate;
        let earlier: Vec<(f64, &Rates)> = row[..row.len() - 1].iter().map(|a| a / gamma).zip(stages).collect();
        let history = History { rate, earlier: &earlier };
        let from = &start.rates;
        for (g, p) in start.shape.node_p.iter().enumerate() {
            (self.node_v[g], self.node_a[g]) = history.of(p, &from.node_v[g], |s| (s.node_v[g], s.node_a[g]));
            for c in 0..6 {
                let before: f64 = earlier.iter().map(|(a, s)| a * s.strain_v[g][c]).sum();
                self.strain_v[g][c] = -start.shape.strain[g][c] * rate - before;
            }
        }
        for (k, mass) in masses.iter().enumerate() {
            let p = &start.shape.end_p[mass.end];
            (self.mass_v[k], self.mass_a[k]) = history.of(p, &from.mass_v[k], |s| (s.mass_v[k], s.mass_a[k]));
            if mass.turns() {
                (self.spin_v[k], self.spin_a[k]) =
                    history.of(&Vector3::zeros(), &from.spin[k], |s| (s.spin[k], s.spin_a[k]));
                self.from_r[k] = start.shape.end_r[mass.end];
            }
        }
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
