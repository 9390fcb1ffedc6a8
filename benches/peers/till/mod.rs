//! The scheme of Till, Aloi & Rucker (2019), "Real-time dynamics of soft and continuum robots based
//! on Cosserat rod models", written anew from the article: the equations of the rod are made
//! implicit in time by BDF-α, what is left is a boundary value problem along the rod, and that is
//! solved by shooting from the base.
//!
//! Beyond the article: pieces of different material (the internal and tendon wrench is continuous
//! across their borders, the strains are not), the axial law of the compressible spine, and a
//! fourth-order integrator along the rod.
#![allow(missing_docs, unreachable_pub, dead_code)]

mod field;
mod history;
mod material;
mod shooting;

use nalgebra::{DVector, Vector3};
use spinebench::rod::{Drive, RodParams};

use field::{Node, Rate};
use history::{Bdf, Record};
use material::Piece;

/// How the equations are integrated along the rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Explicit Euler, as in the authors' tendon example.
    Euler,
    /// The classical fourth-order method; the history between nodes is interpolated by cubics.
    Rk4,
}

/// How the boundary value problem is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// Levenberg–Marquardt with a derivative by finite differences in every iteration, as the
    /// authors do.
    LevenbergMarquardt,
    /// Newton's method that keeps its derivative between iterations and steps as long as it
    /// contracts well.
    Newton,
}

/// Settings of the scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub space: Space,
    /// Nodes along the whole rod, both ends included.
    pub nodes: usize,
    pub time_step_s: f64,
    /// α of BDF-α: 0 is BDF2.
    pub alpha: f64,
    pub solver: Solver,
    /// Sum of squares of force, moment and length errors (SI) at which a solve ends.
    pub tolerance: f64,
    /// Whether the backbone's own cross-sections resist turning.
    pub rotary_inertia: bool,
    /// Whether shear and stretch are damped as bending and twist are.
    pub linear_damping: bool,
    /// Whether Newton's method starts from where the last two steps point rather than from the last
    /// solution.
    pub extrapolate: bool,
}

impl Settings {
    /// The authors' tendon example: Euler at 200 nodes, BDF2 at 50 ms, Levenberg–Marquardt to
    /// 1e-12.
    pub fn published() -> Settings {
        Settings {
            space: Space::Euler,
            nodes: 200,
            time_step_s: 0.05,
            alpha: 0.0,
            solver: Solver::LevenbergMarquardt,
            tolerance: 1e-12,
            rotary_inertia: true,
            linear_damping: false,
            extrapolate: false,
        }
    }
}

/// A rod with `T` tendons that moves by this scheme.
pub struct Till<const T: usize> {
    params: RodParams,
    settings: Settings,
    pieces: Vec<Piece>,
    offsets: [Vector3<f64>; T],
    records: Record,
    bdf: Bdf,
    guess: DVector<f64>,
    memory: shooting::Memory,
    tip: Node<T>,
    /// Shots along the rod so far.
    pub shots: u64,
}

impl<const T: usize> Till<T> {
    /// The rod of `params` with its base at the origin, along z.
    ///
    /// # Errors
    /// What the scheme, as written here, does not cover.
    pub fn new(params: &RodParams, settings: Settings) -> Result<Till<T>, String> {
        if params.tendons.len() != T
            || params.tendons.iter().any(|tendon| tendon.end_m < params.length_m())
        {
            return Err(format!("expected {T} tendons that end at the tip"));
        }
        if !params.masses.is_empty()
            || !params.moment_laws.is_empty()
            || params.base_rotation_rad != Vector3::zeros()
        {
            return Err(
                "lumped masses, moments with a memory and a turned base are not covered".into()
            );
        }
        let pieces = material::pieces(params, &settings);
        let offset = |i: usize| {
            let ([x, y], _) = params.tendons[i].path.at(0.0);
            Vector3::new(x, y, 0.0)
        };
        let count = pieces.iter().map(|piece| piece.records(settings.space)).sum();
        Ok(Till {
            params: params.clone(),
            settings,
            offsets: std::array::from_fn(offset),
            records: Record::new(count),
            bdf: Bdf::rest(),
            guess: DVector::zeros(6 + T),
            memory: shooting::Memory::default(),
            tip: Node::base(&pieces[0], &DVector::zeros(6 + T)),
            pieces,
            shots: 0,
        })
    }

    /// Brings the rod to rest under `drives`, from where the last solve ended.
    ///
    /// # Errors
    /// Why the boundary value problem was not solved.
    pub fn settle(&mut self, drives: &[Drive]) -> Result<(), String> {
        self.bdf = Bdf::rest();
        self.records.clear_history();
        self.memory.forget();
        self.solve(drives)?;
        self.bdf = Bdf::new(self.settings.time_step_s, self.settings.alpha);
        self.records.start(&self.bdf);
        self.memory.forget();
        Ok(())
    }

    /// One time step to the instant for which `drives` are given.
    ///
    /// # Errors
    /// As [`Till::settle`].
    pub fn step(&mut self, drives: &[Drive]) -> Result<(), String> {
        self.solve(drives)?;
        self.records.advance(&self.bdf);
        Ok(())
    }

    /// Forgets the last solution: the next [`Till::settle`] starts cold.
    pub fn forget(&mut self) {
        self.guess.fill(0.0);
    }

    pub fn tip_m(&self) -> Vector3<f64> {
        self.tip.p
    }

    /// Tensions of the tendons, N.
    pub fn tensions_n(&self) -> [f64; T] {
        std::array::from_fn(|i| self.guess[6 + i].max(0.0))
    }

    /// Integrates from the base with the guessed wrench and tensions; the error at the tip. With
    /// `record`, what the next step needs to know of this one is kept.
    fn shoot(&mut self, guess: &DVector<f64>, drives: &[Drive], record: bool) -> DVector<f64> {
        self.shots += 1;
        let tensions: [f64; T] = std::array::from_fn(|i| guess[6 + i].max(0.0));
        let mut node = Node::base(&self.pieces[0], guess);
        let mut first = 0;
        for k in 0..self.pieces.len() {
            if k > 0 {
                self.cross_border(k, first, &tensions, &mut node);
            }
            node = match self.settings.space {
                Space::Euler => self.euler(k, first, &tensions, node, record),
                Space::Rk4 => self.rk4(k, first, &tensions, node, record),
            };
            first += self.pieces[k].records(self.settings.space);
        }
        self.tip = node;
        self.tip_error(guess, drives, &tensions)
    }

    fn euler(
        &mut self,
        k: usize,
        first: usize,
        tensions: &[f64; T],
        start: Node<T>,
        record: bool,
    ) -> Node<T> {
        let piece = &self.pieces[k];
        let h = piece.length_m / piece.cells as f64;
        let mut node = start;
        for j in 0..=piece.cells {
            let rate = self.rate(piece, first + j, tensions, &node);
            if record {
                self.records.now[first + j] = node.remembered(&rate);
            }
            if j < piece.cells {
                node = node.moved(&rate, h);
            }
        }
        node
    }

    fn rk4(
        &mut self,
        k: usize,
        first: usize,
        tensions: &[f64; T],
        start: Node<T>,
        record: bool,
    ) -> Node<T> {
        let piece = &self.pieces[k];
        let h = piece.length_m / piece.cells as f64;
        let mut node = start;
        let mut k1 = self.rate(piece, first, tensions, &node);
        for j in 0..piece.cells {
            let at = first + 2 * j;
            let k2 = self.rate(piece, at + 1, tensions, &node.moved(&k1, 0.5 * h));
            let k3 = self.rate(piece, at + 1, tensions, &node.moved(&k2, 0.5 * h));
            let k4 = self.rate(piece, at + 2, tensions, &node.moved(&k3, h));
            let next = node.moved(&Rate::mean(&k1, &k2, &k3, &k4), h);
            let after = self.rate(piece, at + 2, tensions, &next);
            if record {
                let (from, to) = (node.remembered(&k1), next.remembered(&after));
                self.records.now[at] = from;
                self.records.now[at + 1] =
                    history::middle(&from, &to, &k1.remembered(), &after.remembered(), h);
                self.records.now[at + 2] = to;
            }
            (node, k1) = (next, after);
        }
        node
    }

    /// What is left of the balance at the tip, and of the tendon lengths.
    fn tip_error(
        &self,
        guess: &DVector<f64>,
        drives: &[Drive],
        tensions: &[f64; T],
    ) -> DVector<f64> {
        let piece = &self.pieces[self.pieces.len() - 1];
        let last = self.records.past.len() - 1;
        let (mut force, mut moment) = self.internal_wrench(piece, last, &self.tip);
        force -= self.tip.r.tr_mul(&self.params.tip_load.force_n);
        moment -= self.tip.r.tr_mul(&self.params.tip_load.moment_nm);
        let mut error = DVector::zeros(6 + T);
        for i in 0..T {
            let pull = (self.tip.v + self.tip.u.cross(&self.offsets[i])).normalize() * tensions[i];
            force += pull;
            moment += self.offsets[i].cross(&pull);
            let tendon = &self.params.tendons[i];
            error[6 + i] = match drives[i] {
                Drive::Pull(pull_m) => {
                    let pull_m = pull_m + tendon.pretension_m;
                    let compliance =
                        tendon.compliance_m_per_n * (1.0 - pull_m / tendon.elastic_length_m);
                    let slack = (-guess[6 + i]).max(0.0);
                    self.tip.lengths[i] + pull_m + slack - tendon.end_m - compliance * tensions[i]
                }
                Drive::Tension(wanted) => guess[6 + i] - wanted,
                Drive::Follow => guess[6 + i],
            };
        }
        error.fixed_rows_mut::<3>(0).copy_from(&force);
        error.fixed_rows_mut::<3>(3).copy_from(&moment);
        error
    }
}
