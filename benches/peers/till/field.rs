//! The equations along the rod at one instant (Till et al. 2019, tendon robot; tendons parallel to
//! the backbone).

use nalgebra::{DVector, Matrix3, Matrix6, Vector3, Vector6};

use super::Till;
use super::history::Remembered;
use super::material::Piece;

/// State of a cross-section: pose, strains, velocities (body frame), lengths of the tendons so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node<const T: usize> {
    pub(super) p: Vector3<f64>,
    pub(super) r: Matrix3<f64>,
    pub(super) v: Vector3<f64>,
    pub(super) u: Vector3<f64>,
    pub(super) q: Vector3<f64>,
    pub(super) w: Vector3<f64>,
    pub(super) lengths: [f64; T],
}

/// Its derivative along the rod.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rate<const T: usize>(Node<T>);

impl<const T: usize> Node<T> {
    /// The clamped base with the guessed strains: the force enters through the elastic law alone,
    /// which is a matter of scale only.
    pub(super) fn base(piece: &Piece, guess: &DVector<f64>) -> Node<T> {
        let n = guess.fixed_rows::<3>(0);
        let v = Vector3::new(
            n[0] / piece.shear_n,
            n[1] / piece.shear_n,
            1.0 + n[2] * piece.axial_per_n,
        );
        let zero = Vector3::zeros();
        let u = guess.fixed_rows::<3>(3).into_owned();
        Node { p: zero, r: Matrix3::identity(), v, u, q: zero, w: zero, lengths: [0.0; T] }
    }

    pub(super) fn moved(&self, rate: &Rate<T>, h: f64) -> Node<T> {
        let d = &rate.0;
        Node {
            p: self.p + d.p * h,
            r: self.r + d.r * h,
            v: self.v + d.v * h,
            u: self.u + d.u * h,
            q: self.q + d.q * h,
            w: self.w + d.w * h,
            lengths: std::array::from_fn(|i| self.lengths[i] + d.lengths[i] * h),
        }
    }

    pub(super) fn remembered(&self, rate: &Rate<T>) -> Remembered {
        [self.v, self.u, self.q, self.w, rate.0.v, rate.0.u]
    }
}

impl<const T: usize> Rate<T> {
    /// The mean of the four slopes of the classical Runge–Kutta method.
    pub(super) fn mean(k1: &Rate<T>, k2: &Rate<T>, k3: &Rate<T>, k4: &Rate<T>) -> Rate<T> {
        let (a, b, c, d) = (&k1.0, &k2.0, &k3.0, &k4.0);
        let vector = |pick: fn(&Node<T>) -> Vector3<f64>| {
            (pick(a) + (pick(b) + pick(c)) * 2.0 + pick(d)) / 6.0
        };
        Rate(Node {
            p: vector(|n| n.p),
            r: (a.r + (b.r + c.r) * 2.0 + d.r) / 6.0,
            v: vector(|n| n.v),
            u: vector(|n| n.u),
            q: vector(|n| n.q),
            w: vector(|n| n.w),
            lengths: std::array::from_fn(|i| {
                (a.lengths[i] + 2.0 * (b.lengths[i] + c.lengths[i]) + d.lengths[i]) / 6.0
            }),
        })
    }

    /// Slopes of v, u, q and ω.
    pub(super) fn remembered(&self) -> [Vector3<f64>; 4] {
        [self.0.v, self.0.u, self.0.q, self.0.w]
    }
}

/// Stiffness against a change of the strains, and the tendons' part of the balance.
struct Tendons<const T: usize> {
    stiffness: Matrix6<f64>,
    force: Vector3<f64>,
    moment: Vector3<f64>,
    stretch: [f64; T],
}

impl<const T: usize> Till<T> {
    /// Internal force and moment of the rod alone (elastic and viscous), body frame, at record
    /// `at`.
    pub(super) fn internal_wrench(
        &self,
        piece: &Piece,
        at: usize,
        node: &Node<T>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let [v_past, u_past, ..] = &self.records.past[at];
        let (elastic, _) = piece.force(&node.v);
        let c0 = self.bdf.c0;
        let force = elastic + piece.linear_viscosity.component_mul(&(node.v * c0 + v_past));
        let moment = piece.turning_n_m2.component_mul(&node.u)
            + piece.turning_viscosity.component_mul(&(node.u * c0 + u_past));
        if c0 == 0.0 {
            (elastic, piece.turning_n_m2.component_mul(&node.u))
        } else {
            (force, moment)
        }
    }

    /// Derivatives along the rod at record `at`.
    pub(super) fn rate(
        &self,
        piece: &Piece,
        at: usize,
        tensions: &[f64; T],
        node: &Node<T>,
    ) -> Rate<T> {
        let Node { r, v, u, q, w, .. } = node;
        let [v_past, u_past, q_past, w_past, vs_past, us_past] = &self.records.past[at];
        let c0 = self.bdf.c0;
        let tendons = self.tendons(piece, tensions, node);
        let (n, m) = self.internal_wrench(piece, at, node);
        let (v_t, u_t, q_t, w_t) =
            (v * c0 + v_past, u * c0 + u_past, q * c0 + q_past, w * c0 + w_past);
        let inertia = &piece.inertia_kg_m;
        let force = -tendons.force
            + (w.cross(q) + q_t) * piece.mass_kg_m
            + q.component_mul(&q.abs()) * self.params.drag_n_s2_m3
            - r.tr_mul(&self.params.gravity_m_s2) * piece.mass_kg_m
            - u.cross(&n)
            - piece.linear_viscosity.component_mul(vs_past);
        let moment =
            -tendons.moment + w.cross(&inertia.component_mul(w)) + inertia.component_mul(&w_t)
                - v.cross(&n)
                - u.cross(&m)
                - piece.turning_viscosity.component_mul(us_past);
        let mut slopes = Vector6::zeros();
        slopes.fixed_rows_mut::<3>(0).copy_from(&force);
        slopes.fixed_rows_mut::<3>(3).copy_from(&moment);
        // A matrix that is not positive definite ends as a residual that is not a number, which the
        // solver sees.
        match tendons.stiffness.cholesky() {
            Some(factors) => factors.solve_mut(&mut slopes),
            None => slopes.fill(f64::NAN),
        }
        Rate(Node {
            p: r * v,
            r: r * u.cross_matrix(),
            v: slopes.fixed_rows::<3>(0).into_owned(),
            u: slopes.fixed_rows::<3>(3).into_owned(),
            q: v_t - u.cross(q) + w.cross(v),
            w: u_t - u.cross(w),
            lengths: tendons.stretch,
        })
    }

    fn tendons(&self, piece: &Piece, tensions: &[f64; T], node: &Node<T>) -> Tendons<T> {
        let c0 = self.bdf.c0;
        let (_, stiffness) = piece.force(&node.v);
        let mut linear = Matrix3::from_diagonal(&(stiffness + piece.linear_viscosity * c0));
        let mut turning =
            Matrix3::from_diagonal(&(piece.turning_n_m2 + piece.turning_viscosity * c0));
        let mut mixed = Matrix3::zeros();
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let mut stretch = [0.0; T];
        for i in 0..T {
            let path = node.v + node.u.cross(&self.offsets[i]);
            stretch[i] = path.norm();
            if tensions[i] == 0.0 {
                continue;
            }
            let t = path / stretch[i];
            let a = (Matrix3::identity() - t * t.transpose()) * (tensions[i] / stretch[i]);
            let hat = self.offsets[i].cross_matrix();
            let g = -(a * hat);
            let bend = node.u.cross(&t) * tensions[i];
            force += bend;
            moment += self.offsets[i].cross(&bend);
            linear += a;
            mixed += g;
            turning += hat * g;
        }
        let mut all = Matrix6::zeros();
        all.fixed_view_mut::<3, 3>(0, 0).copy_from(&linear);
        all.fixed_view_mut::<3, 3>(0, 3).copy_from(&mixed);
        all.fixed_view_mut::<3, 3>(3, 0).copy_from(&mixed.transpose());
        all.fixed_view_mut::<3, 3>(3, 3).copy_from(&turning);
        Tendons { stiffness: all, force, moment, stretch }
    }

    /// Force and moment of rod and tendons together, body frame.
    fn total_wrench(
        &self,
        piece: &Piece,
        at: usize,
        tensions: &[f64; T],
        node: &Node<T>,
    ) -> Vector6<f64> {
        let (mut force, mut moment) = self.internal_wrench(piece, at, node);
        for i in 0..T {
            let pull = (node.v + node.u.cross(&self.offsets[i])).normalize() * tensions[i];
            force += pull;
            moment += self.offsets[i].cross(&pull);
        }
        Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
    }

    /// Enters piece `k`, whose first record is `first`: the strains jump so that the wrench does
    /// not.
    pub(super) fn cross_border(
        &self,
        k: usize,
        first: usize,
        tensions: &[f64; T],
        node: &mut Node<T>,
    ) {
        let wanted = self.total_wrench(&self.pieces[k - 1], first - 1, tensions, node);
        let piece = &self.pieces[k];
        for _ in 0..20 {
            let error = self.total_wrench(piece, first, tensions, node) - wanted;
            let stiffness = self.tendons(piece, tensions, node).stiffness;
            let Some(factors) = stiffness.cholesky() else { return };
            let step = factors.solve(&error);
            node.v -= step.fixed_rows::<3>(0);
            node.u -= step.fixed_rows::<3>(3);
            if step.amax() < 1e-13 * (1.0 + node.u.amax()) {
                return;
            }
        }
    }
}
