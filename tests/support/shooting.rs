//! An independent oracle for statics: Rucker & Webster's (2011) differential equations of a rod
//! with tendons on any path, in strong form with distributed tendon loads, integrated with RK4 and
//! closed by shooting from the base.
#![allow(dead_code, unreachable_pub, missing_docs)]

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};

/// Offset of a tendon with its first and second derivative, metres.
pub type Path = Box<dyn Fn(f64) -> [Vector3<f64>; 3]>;

pub struct Cord {
    pub path: Path,
    pub start_m: f64,
    pub end_m: f64,
    pub tension_n: f64,
}

/// Stiffness of (u, v) and its derivative, by the distance from the base.
pub type Stiffness = Box<dyn Fn(f64) -> (Vector6<f64>, Vector6<f64>)>;

/// A rod in the body frame: strains (u, v), diagonal stiffness.
pub struct Shooting {
    /// Stiffness of (u, v) and its derivative with s.
    pub stiffness: Stiffness,
    pub rest: Box<dyn Fn(f64) -> Vector3<f64>>,
    pub cords: Vec<Cord>,
    /// World force per length.
    pub line: Box<dyn Fn(f64) -> Vector3<f64>>,
    /// Force and moment (world) at places inside.
    pub points: Vec<(f64, Vector3<f64>, Vector3<f64>)>,
    pub tip_force: Vector3<f64>,
    pub tip_moment: Vector3<f64>,
    /// The tip load turns with the tip.
    pub follows: bool,
    /// Where anything jumps, base and tip included.
    pub borders: Vec<f64>,
    pub steps: usize,
    /// Share of all loads and tensions, raised from 0 to 1 on the way.
    pub share: f64,
}

#[derive(Clone, Copy)]
pub struct Pose {
    pub p: Vector3<f64>,
    pub r: Matrix3<f64>,
    /// Strains u, v.
    pub strain: Vector6<f64>,
}

fn cross(a: &Vector3<f64>) -> Matrix3<f64> {
    a.cross_matrix()
}

fn parts(six: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (six.fixed_rows::<3>(0).into(), six.fixed_rows::<3>(3).into())
}

fn join(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
}

impl Shooting {
    fn active(&self, middle: f64) -> impl Iterator<Item = &Cord> {
        self.cords.iter().filter(move |cord| cord.start_m < middle && middle < cord.end_m)
    }

    /// Internal wrench (m, n) of the rod alone.
    fn wrench(&self, s: f64, strain: &Vector6<f64>) -> Vector6<f64> {
        (self.stiffness)(s).0.component_mul(&(strain - self.unloaded(s)))
    }

    fn unloaded(&self, s: f64) -> Vector6<f64> {
        join(&(self.rest)(s), &Vector3::z())
    }

    /// Rod and tendons together; `middle` lies in the piece whose tendons and paths count.
    fn total(&self, s: f64, middle: f64, strain: &Vector6<f64>) -> Vector6<f64> {
        let (u, v) = parts(strain);
        let mut total = self.wrench(nudge(s, middle), strain);
        for cord in self.active(middle) {
            let [r, dr, _] = (cord.path)(nudge(s, middle));
            let t = (v + u.cross(&r) + dr).normalize() * (cord.tension_n * self.share);
            total += join(&r.cross(&t), &t);
        }
        total
    }

    /// Strains just inside the piece around `middle` for a given total wrench.
    fn strain_for(
        &self,
        s: f64,
        middle: f64,
        total: &Vector6<f64>,
        guess: &Vector6<f64>,
    ) -> Vector6<f64> {
        let mut strain = *guess;
        for _ in 0..50 {
            let off = self.total(s, middle, &strain) - total;
            let columns: Vec<Vector6<f64>> = (0..6)
                .map(|k| {
                    let mut moved = strain;
                    moved[k] += 1e-7;
                    (self.total(s, middle, &moved) - total - off) / 1e-7
                })
                .collect();
            let step = Matrix6::from_columns(&columns).lu().solve(&off).expect("a regular border");
            strain -= step;
            if step.norm() <= 1e-13 * strain.norm() {
                break;
            }
        }
        strain
    }

    /// Strong form: derivative of the strains.
    fn strain_rate(
        &self,
        s: f64,
        middle: f64,
        r: &Matrix3<f64>,
        strain: &Vector6<f64>,
    ) -> Vector6<f64> {
        let (u, v) = parts(strain);
        let (k, dk) = (self.stiffness)(s);
        let (m, n) = parts(&self.wrench(s, strain));
        // K (strain)' + K' (strain − rest) + transport + Σ tendon loads = 0, the loads affine in
        // the strain rate.
        let mut matrix = Matrix6::from_diagonal(&k);
        let mut load = dk.component_mul(&(strain - self.unloaded(s)));
        load += join(
            &(u.cross(&m) + v.cross(&n)),
            &(u.cross(&n) + r.tr_mul(&(self.line)(s)) * self.share),
        );
        for cord in self.active(middle) {
            let [o, d, dd] = (cord.path)(s);
            let a = v + u.cross(&o) + d;
            let project = -cross(&a) * cross(&a) * (self.share * cord.tension_n / a.norm().powi(3));
            // a′ + u × a = v′ + u′ × r + [u × r′ + r″ + u × a]
            let known = u.cross(&d) + dd + u.cross(&a);
            let force = project * known;
            load += join(&o.cross(&force), &force);
            let (du, dv) = (-project * cross(&o), project);
            let mut block = SMatrix::<f64, 6, 6>::zeros();
            block.fixed_view_mut::<3, 3>(0, 0).copy_from(&(cross(&o) * du));
            block.fixed_view_mut::<3, 3>(0, 3).copy_from(&(cross(&o) * dv));
            block.fixed_view_mut::<3, 3>(3, 0).copy_from(&du);
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(&dv);
            matrix += block;
        }
        matrix.lu().solve(&-load).expect("a regular cross-section")
    }

    fn rate(&self, s: f64, middle: f64, pose: &Pose) -> Pose {
        let (u, v) = parts(&pose.strain);
        Pose {
            p: pose.r * v,
            r: pose.r * cross(&u),
            strain: self.strain_rate(nudge(s, middle), middle, &pose.r, &pose.strain),
        }
    }

    /// Integrates from the base and gives the pose at the tip.
    fn integrate(&self, base_total: &Vector6<f64>) -> Pose {
        let straight = join(&(self.rest)(0.0), &Vector3::z());
        let mut pose = Pose { p: Vector3::zeros(), r: Matrix3::identity(), strain: straight };
        let mut total = *base_total;
        for window in self.borders.windows(2) {
            let (from, to) = (window[0], window[1]);
            let middle = 0.5 * (from + to);
            pose.strain = self.strain_for(from, middle, &total, &pose.strain);
            let h = (to - from) / self.steps as f64;
            for k in 0..self.steps {
                pose = self.runge_kutta(from + k as f64 * h, h, middle, &pose);
            }
            total = self.total(to, middle, &pose.strain);
            for (_, force, moment) in self.points.iter().filter(|(s, _, _)| (s - to).abs() < 1e-12)
            {
                total -= join(&pose.r.tr_mul(moment), &pose.r.tr_mul(force)) * self.share;
            }
        }
        Pose { strain: total, ..pose }
    }

    fn runge_kutta(&self, s: f64, h: f64, middle: f64, pose: &Pose) -> Pose {
        let add = |a: &Pose, b: &Pose, x: f64| Pose {
            p: a.p + b.p * x,
            r: a.r + b.r * x,
            strain: a.strain + b.strain * x,
        };
        let k1 = self.rate(s, middle, pose);
        let k2 = self.rate(s + 0.5 * h, middle, &add(pose, &k1, 0.5 * h));
        let k3 = self.rate(s + 0.5 * h, middle, &add(pose, &k2, 0.5 * h));
        let k4 = self.rate(s + h, middle, &add(pose, &k3, h));
        let mut next = *pose;
        for (k, x) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
            next = add(&next, &k, x * h / 6.0);
        }
        next
    }

    /// What is missing at the tip: total wrench minus load.
    fn miss(&self, base_total: &Vector6<f64>) -> Vector6<f64> {
        let tip = self.integrate(base_total);
        let (force, moment) = if self.follows {
            (self.tip_force, self.tip_moment)
        } else {
            (tip.r.tr_mul(&self.tip_force), tip.r.tr_mul(&self.tip_moment))
        };
        tip.strain - join(&moment, &force) * self.share
    }

    /// Tip pose at equilibrium: loads raised step by step, each step by Newton's method with
    /// differences.
    pub fn solve(mut self) -> Pose {
        let mut base = Vector6::zeros();
        let (mut reached, mut step) = (0.0, 0.1);
        while reached < 1.0 {
            self.share = f64::min(reached + step, 1.0);
            if let Some(found) = self.newton(base) {
                (base, reached) = (found, self.share);
            } else {
                step *= 0.5;
                assert!(step > 1e-4, "the shot misses beyond {reached} of the load");
            }
        }
        self.integrate(&base)
    }

    fn newton(&self, mut base: Vector6<f64>) -> Option<Vector6<f64>> {
        for _ in 0..20 {
            let off = self.miss(&base);
            if off.norm() < 1e-11 {
                return Some(base);
            }
            let column = |k: usize| {
                let mut moved = base;
                moved[k] += 1e-6;
                (self.miss(&moved) - off) / 1e-6
            };
            let columns: Vec<Vector6<f64>> = (0..6).map(column).collect();
            base -= Matrix6::from_columns(&columns).lu().solve(&off)?;
        }
        None
    }
}

/// Moves a place at a border a little into the piece around `middle`.
fn nudge(s: f64, middle: f64) -> f64 {
    s + (middle - s) * 1e-12
}
