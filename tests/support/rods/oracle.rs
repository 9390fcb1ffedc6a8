//! An independent judge of static answers: the same rod by shooting, with a local Newton solve for
//! the strains at every Runge–Kutta stage. It shares no discretisation with the rod that it judges.
#![allow(dead_code, unreachable_pub, missing_docs)]

use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3, Vector6};
use spinebench::rod::{Drive, Rod};

use super::random_robot::{Case, bending_n_m2};

/// Runge–Kutta steps along the rod …
pub const STEPS: f64 = 400.0;
/// … and where that is not yet a verdict: where the spine saturates between two places, its strain
/// has a kink.
pub const FINE_STEPS: f64 = 3200.0;
/// The same for derivatives, which only have to lead there.
const ROUGH_STEPS: f64 = 80.0;

/// Corrections of the base wrench before the oracle gives up.
const MOST_CORRECTIONS: usize = 15;
const MOST_HALVINGS: usize = 10;

/// What the oracle finds next to the rod's answer.
#[derive(Clone, Debug)]
pub struct Verdict {
    pub tip_m: Vector3<f64>,
    pub rotation: Matrix3<f64>,
    /// By how much the tip's moment balance and the taut tendons' lengths stay open, relative to E
    /// I/L and L.
    pub open: f64,
    /// The same before the first correction: what the rod's own answer leaves open.
    pub open_at_start: f64,
    /// By how much the tendon that should be slack and is not is too long, metres.
    pub overstretch_m: f64,
}

struct Shooting<'a> {
    case: &'a Case,
    tensions: Vec<f64>,
    /// Ends of the pieces between jumps.
    cuts: Vec<f64>,
}

#[derive(Clone)]
struct Section {
    p: Vector3<f64>,
    r: Matrix3<f64>,
    force: Vector3<f64>,
    moment: Vector3<f64>,
    lengths: DVector<f64>,
}

impl Section {
    fn plus(&self, rate: &Section, h: f64) -> Section {
        Section {
            p: self.p + rate.p * h,
            r: self.r + rate.r * h,
            force: self.force + rate.force * h,
            moment: self.moment + rate.moment * h,
            lengths: &self.lengths + &rate.lengths * h,
        }
    }
}

/// Shoots in `steps` steps from the base wrench that the rod's own shape implies; none when the
/// local law cannot be solved.
pub fn judge(case: &Case, rod: &Rod, steps: f64) -> Option<Verdict> {
    let tensions = rod.tensions_n().to_vec();
    let length = case.params.length_m();
    let moment_scale = bending_n_m2(&case.params) / length;
    // Less than this is what the solver's tolerance leaves.
    let least_n = 1e-9 * moment_scale / length;
    let held = |i: &usize| matches!(case.drives[*i], Drive::Pull(_)) && tensions[*i] > least_n;
    let taut: Vec<usize> = (0..tensions.len()).filter(held).collect();
    let mut shooting = Shooting { case, tensions, cuts: cuts(case) };
    let mut x = DVector::zeros(3 + taut.len());
    x.rows_mut(0, 3).copy_from(&(base_moment(case, rod) / moment_scale));
    for (k, &i) in taut.iter().enumerate() {
        x[3 + k] = shooting.tensions[i] * length / moment_scale;
    }
    let mut residual = |x: &DVector<f64>, steps: f64| {
        for (k, &i) in taut.iter().enumerate() {
            shooting.tensions[i] = x[3 + k] * moment_scale / length;
        }
        let base: Vector3<f64> = x.fixed_rows::<3>(0) * moment_scale;
        let end = shooting.integrate(base, steps)?;
        let mut out = DVector::zeros(x.len());
        out.rows_mut(0, 3).copy_from(&((end.moment - case.load.moment_nm) / moment_scale));
        for (k, &i) in taut.iter().enumerate() {
            out[3 + k] = shooting.overstretch_m(i, &end) / length;
        }
        Some((out, end))
    };
    let (mut r, mut end) = residual(&x, steps)?;
    let open_at_start = r.norm();
    let (mut factors, mut before) = (None, f64::INFINITY);
    for _ in 0..MOST_CORRECTIONS {
        let open = r.norm();
        if open < 1e-11 {
            break;
        }
        // The derivative serves as long as it takes nine tenths off.
        if factors.is_none() || open > 0.1 * before {
            factors = Some(derivative(&mut residual, &x)?.lu());
        }
        before = open;
        let mut step: DVector<f64> = factors.as_ref()?.solve(&r)?;
        let mut after = residual(&(&x - &step), steps);
        for _ in 0..MOST_HALVINGS {
            if after.as_ref().is_some_and(|(r, _)| r.norm() < 2.0 * open) {
                break;
            }
            step *= 0.5;
            after = residual(&(&x - &step), steps);
        }
        x -= step;
        (r, end) = after?;
    }
    let slack = (0..case.drives.len())
        .filter(|i| matches!(case.drives[*i], Drive::Pull(_)) && !taut.contains(i));
    let overstretch_m = slack.map(|i| shooting.overstretch_m(i, &end)).fold(0.0, f64::max);
    Some(Verdict { tip_m: end.p, rotation: end.r, open: r.norm(), open_at_start, overstretch_m })
}

/// Derivative of `residual` at `x` by differences.
fn derivative(
    residual: &mut impl FnMut(&DVector<f64>, f64) -> Option<(DVector<f64>, Section)>,
    x: &DVector<f64>,
) -> Option<DMatrix<f64>> {
    let mut jacobian = DMatrix::zeros(x.len(), x.len());
    let here = residual(x, ROUGH_STEPS)?.0;
    for k in 0..x.len() {
        let h = 1e-6 * (1.0 + x[k].abs());
        let mut other = x.clone();
        other[k] += h;
        jacobian.set_column(k, &((residual(&other, ROUGH_STEPS)?.0 - &here) / h));
    }
    Some(jacobian)
}

fn cuts(case: &Case) -> Vec<f64> {
    let p = &case.params;
    let mut cuts: Vec<f64> = p.spans.iter().map(|span| span.end_m).collect();
    cuts.extend(p.masses.iter().map(|mass| mass.position_m));
    cuts.extend(p.tendons.iter().map(|tendon| tendon.end_m));
    cuts.extend(p.sections.iter().flat_map(|s| [s.start_m, s.start_m + s.length_m]));
    cuts.retain(|&s| s > 1e-9);
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|b, a| *b - *a < 1e-9);
    cuts
}

/// Moment about the base of all loads on the shape that the rod found. Its cross-sections lie in
/// pairs at the two Gauss points of a cell, which tell the cell's length.
fn base_moment(case: &Case, rod: &Rod) -> Vector3<f64> {
    let (p, g) = (&case.params, case.params.gravity_m_s2);
    let base = p.base_m;
    let mut moment = case.load.moment_nm + (rod.tip_m() - base).cross(&case.load.force_n);
    for pair in rod.cross_sections().chunks(2) {
        let half = 0.5 * 3.0_f64.sqrt() * (pair[1].s_m - pair[0].s_m);
        for place in pair {
            let span = p.span_at(place.s_m);
            let force = (span.mass_kg_m + span.spread_mass_kg_m) * half * g;
            moment += (place.position_m - base).cross(&force);
        }
    }
    for mass in &p.masses {
        moment += (rod.pose_at(mass.position_m).0 - base).cross(&(mass.mass_kg * g));
    }
    moment
}

impl Shooting<'_> {
    fn overstretch_m(&self, i: usize, end: &Section) -> f64 {
        let tendon = &self.case.params.tendons[i];
        let Drive::Pull(pull) = self.case.drives[i] else { return 0.0 };
        end.lengths[i] + pull + tendon.pretension_m
            - tendon.end_m
            - tendon.compliance_m_per_n * self.tensions[i]
    }

    fn integrate(&self, base_moment: Vector3<f64>, steps: f64) -> Option<Section> {
        let p = &self.case.params;
        let weight = |from: f64| -> Vector3<f64> {
            let lumps: f64 =
                p.masses.iter().filter(|m| m.position_m > from).map(|m| m.mass_kg).sum();
            lumps * p.gravity_m_s2
        };
        let mut at = Section {
            p: p.base_m,
            r: nalgebra::Rotation3::new(p.base_rotation_rad).into_inner(),
            force: self.case.load.force_n + weight(0.0),
            moment: base_moment,
            lengths: DVector::zeros(p.tendons.len()),
        };
        let mut start = 0.0;
        for piece in self.cuts.windows(2) {
            let middle = 0.5 * (piece[0] + piece[1]);
            let span = p.span_at(middle);
            at.force +=
                (span.mass_kg_m + span.spread_mass_kg_m) * (piece[1] - piece[0]) * p.gravity_m_s2;
        }
        let first = p.span_at(0.5 * self.cuts[0]);
        at.force += (first.mass_kg_m + first.spread_mass_kg_m) * self.cuts[0] * p.gravity_m_s2;
        let mut strain = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        for &end in &self.cuts {
            let middle = 0.5 * (start + end);
            let count = ((end - start) / p.length_m() * steps).ceil().max(4.0);
            let h = (end - start) / count;
            for _ in 0..count as usize {
                let a = self.rates(middle, &at, &mut strain)?;
                let b = self.rates(middle, &at.plus(&a, 0.5 * h), &mut strain)?;
                let c = self.rates(middle, &at.plus(&b, 0.5 * h), &mut strain)?;
                let d = self.rates(middle, &at.plus(&c, h), &mut strain)?;
                at = at.plus(&a, h / 6.0).plus(&b, h / 3.0).plus(&c, h / 3.0).plus(&d, h / 6.0);
            }
            for mass in p.masses.iter().filter(|mass| (mass.position_m - end).abs() < 1e-8) {
                at.force -= mass.mass_kg * p.gravity_m_s2;
            }
            start = end;
        }
        at.moment.iter().all(|x| x.is_finite()).then_some(at)
    }

    /// Derivatives along the rod inside the piece around `middle`.
    fn rates(&self, middle: f64, at: &Section, strain: &mut Vector6<f64>) -> Option<Section> {
        let p = &self.case.params;
        self.solve_strain(middle, at, strain)?;
        let (u, v) = (
            Vector3::new(strain[0], strain[1], strain[2]),
            Vector3::new(strain[3], strain[4], strain[5]),
        );
        let tangent = at.r * v;
        let span = p.span_at(middle);
        let lengths = p.tendons.iter().map(|tendon| {
            let ([x, y], _) = tendon.path.at(0.0);
            if middle < tendon.end_m { (v + u.cross(&Vector3::new(x, y, 0.0))).norm() } else { 0.0 }
        });
        Some(Section {
            p: tangent,
            r: at.r * u.cross_matrix(),
            force: -(span.mass_kg_m + span.spread_mass_kg_m) * p.gravity_m_s2,
            moment: -tangent.cross(&at.force),
            lengths: DVector::from_iterator(p.tendons.len(), lengths),
        })
    }

    /// Strains at which the rod, its histories and the tendons balance the carried wrench: the
    /// least of a convex energy, by Newton's method that goes no further along a step than the
    /// energy falls.
    fn solve_strain(&self, middle: f64, at: &Section, strain: &mut Vector6<f64>) -> Option<()> {
        let length = self.case.params.length_m();
        let (moment, force) = (at.r.tr_mul(&at.moment), at.r.tr_mul(&at.force));
        let wanted = Vector6::new(moment.x, moment.y, moment.z, force.x, force.y, force.z);
        let (mut wrench, mut tangent) = self.wrench(middle, strain);
        for _ in 0..100 {
            let open = wrench - wanted;
            let mut step = tangent.lu().solve(&open)?;
            let start = *strain;
            for _ in 0..30 {
                *strain = start - step;
                (wrench, tangent) = self.wrench(middle, strain);
                // Beyond the least the energy rises along the step.
                if -(wrench - wanted).dot(&step) <= 0.5 * open.dot(&step) {
                    break;
                }
                step *= 0.5;
            }
            let size = step.fixed_rows::<3>(0).norm() * length + step.fixed_rows::<3>(3).norm();
            if !size.is_finite() {
                return None;
            }
            if size < 1e-13 * (1.0 + strain.norm() * length) {
                return Some(());
            }
        }
        None
    }

    /// Wrench of the material and the tendons at these strains, and its derivative.
    fn wrench(&self, middle: f64, strain: &Vector6<f64>) -> (Vector6<f64>, Matrix6<f64>) {
        let p = &self.case.params;
        let (mut wrench, mut tangent) = self.material(middle, strain);
        for (tendon, &tension) in p.tendons.iter().zip(&self.tensions) {
            if middle > tendon.end_m || tension == 0.0 {
                continue;
            }
            let ([x, y], _) = tendon.path.at(0.0);
            let map = nalgebra::Matrix3x6::new(
                0.0, 0.0, -y, 1.0, 0.0, 0.0, //
                0.0, 0.0, x, 0.0, 1.0, 0.0, //
                y, -x, 0.0, 0.0, 0.0, 1.0,
            );
            let path = map * strain;
            let (stretch, t) = (path.norm(), path.normalize());
            wrench += map.transpose() * t * tension;
            let lateral = (Matrix3::identity() - t * t.transpose()) * (tension / stretch);
            tangent += map.transpose() * lateral * map;
        }
        (wrench, tangent)
    }

    /// Wrench of the rod's own material, histories at rest included, and its derivative.
    fn material(&self, middle: f64, strain: &Vector6<f64>) -> (Vector6<f64>, Matrix6<f64>) {
        let p = &self.case.params;
        let span = p.span_at(middle);
        let (sin, cos) = span.principal_angle_rad.sin_cos();
        let [k1, k2] = span.bending_n_m2;
        let mut tangent = Matrix6::zeros();
        tangent[(0, 0)] = k1 * cos * cos + k2 * sin * sin;
        tangent[(0, 1)] = (k1 - k2) * sin * cos;
        tangent[(1, 0)] = tangent[(0, 1)];
        tangent[(1, 1)] = k1 * sin * sin + k2 * cos * cos;
        tangent[(2, 2)] = span.torsion_n_m2;
        tangent[(3, 3)] = span.shear_n;
        tangent[(4, 4)] = span.shear_n;
        tangent[(5, 5)] = span.axial_n;
        let rest = span.rest_curvature_rad_m;
        let mut wrench = tangent * (strain - Vector6::new(rest.x, rest.y, rest.z, 0.0, 0.0, 1.0));
        let inside = |s: &&spinebench::rod::CompressibleSection| {
            (s.start_m..s.start_m + s.length_m).contains(&middle)
        };
        if let Some(section) = p.sections.iter().find(inside) {
            let (soft, stiff) =
                (section.compliance_m_per_n / section.length_m + 1.0 / span.axial_n, span.axial_n);
            let beyond = strain[5] - 1.0 + soft * section.saturation_n;
            let saturated = beyond < 0.0;
            wrench[5] = if saturated {
                stiff * beyond - section.saturation_n
            } else {
                (strain[5] - 1.0) / soft
            };
            tangent[(5, 5)] = if saturated { stiff } else { 1.0 / soft };
        }
        for law in &p.moment_laws {
            let history = law.settled(
                &[0.0; 4],
                [strain[0] - rest.x, strain[1] - rest.y],
                0.5 * (k1 + k2),
                f64::INFINITY,
            );
            for a in 0..2 {
                wrench[a] += history.moment_nm[a];
                for b in 0..2 {
                    tangent[(a, b)] += history.tangent_n_m2[a][b];
                }
            }
        }
        (wrench, tangent)
    }
}
