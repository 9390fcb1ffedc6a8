//! Random robots and commands: every feature of the rod, from harmless to far beyond what a robot
//! could bear.
#![allow(dead_code, unreachable_pub, missing_docs)]

use nalgebra::Vector3;
use rand::{Rng, RngExt};
use spinebench::base::Seed;
use spinebench::rod::{CompressibleSection, Drive, PointMass, RodParams, Tendon, TipWrench};

/// A robot and one command.
#[derive(Clone, Debug)]
pub struct Case {
    pub params: RodParams,
    pub load: TipWrench,
    pub drives: Vec<Drive>,
    /// Angle to which the command would bend a rod without other loads, rad.
    pub angle_rad: f64,
}

/// Log-uniform draw.
pub fn log(random: &mut impl Rng, low: f64, high: f64) -> f64 {
    (random.random_range(low.ln()..high.ln())).exp()
}

fn chance(random: &mut impl Rng, share: f64) -> bool {
    random.random_range(0.0..1.0) < share
}

fn direction(random: &mut impl Rng) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        if (0.01..1.0).contains(&v.norm_squared()) {
            return v.normalize();
        }
    }
}

/// The case of a seed.
pub fn case(seed: Seed) -> Case {
    let mut random = seed.rng();
    let params = robot(&mut random);
    let (load, angle_rad) = (tip_load(&mut random, &params), log(&mut random, 1e-3, 30.0));
    let drives = drives(&mut random, &params, angle_rad);
    Case { params, load, drives, angle_rad }
}

/// Mean bending stiffness of the first span, N m².
pub fn bending_n_m2(params: &RodParams) -> f64 {
    let [a, b] = params.spans[0].bending_n_m2;
    0.5 * (a + b)
}

/// A robot of any size and build.
pub fn robot(random: &mut impl Rng) -> RodParams {
    let length = log(random, 0.05, 1.0);
    let radius = length / log(random, 30.0, 300.0);
    let e = log(random, 1e6, 2e11);
    let g = e / (2.0 * (1.0 + random.random_range(0.0..0.5)));
    let stiffness = 0.25 * std::f64::consts::PI * radius.powi(4) * e;
    // Weight in units of the load that bends the rod by about a radian.
    let mass = log(random, 1e-3, 20.0) * stiffness / (length * length * 9.81);
    let lumped = if chance(random, 0.5) { random.random_range(0.0..0.95) } else { 0.0 };
    let mut params = super::round_rod(length, radius, e, g, (1.0 - lumped) * mass / length);
    if lumped > 0.0 {
        add_disks(random, &mut params, lumped * mass, radius);
    }
    add_shape(random, &mut params);
    if chance(random, 0.5) {
        add_sections(random, &mut params);
    }
    add_tendons(random, &mut params);
    if chance(random, 0.8) {
        params.gravity_m_s2 = 9.81 * direction(random);
    }
    if chance(random, 0.2) {
        params.base_m = 0.3 * direction(random);
        params.base_rotation_rad = random.random_range(0.0..3.1) * direction(random);
    }
    params.damping_time_s = if chance(random, 0.8) { log(random, 1e-3, 0.1) } else { 0.0 };
    add_memory(random, &mut params);
    params
}

fn add_disks(random: &mut impl Rng, params: &mut RodParams, mass_kg: f64, radius: f64) {
    let (count, length) = (random.random_range(1..13), params.length_m());
    let each = mass_kg / f64::from(count);
    let inertia = if chance(random, 0.3) { each * radius * radius * 5.0 } else { 0.0 };
    params.masses = (1..=count)
        .map(|k| PointMass {
            position_m: length * f64::from(k) / f64::from(count),
            mass_kg: each,
            inertia_kg_m2: Vector3::new(0.5, 0.5, 1.0) * inertia,
        })
        .collect();
}

/// Several spans, unequal axes, a rest shape that is not straight.
fn add_shape(random: &mut impl Rng, params: &mut RodParams) {
    let length = params.length_m();
    if chance(random, 0.3) {
        params.split_at(random.random_range(0.1..0.9) * length);
        let factor = log(random, 0.3, 3.0);
        params.spans[1].bending_n_m2 = params.spans[1].bending_n_m2.map(|k| factor * k);
        params.spans[1].torsion_n_m2 *= factor;
    }
    if chance(random, 0.3) {
        let (ratio, angle) = (log(random, 0.4, 2.5), random.random_range(0.0..3.0));
        for span in &mut params.spans {
            span.bending_n_m2[0] *= ratio;
            span.principal_angle_rad = angle;
        }
    }
    if chance(random, 0.3) {
        let bend = random.random_range(0.0..2.0) / length * direction(random);
        params.spans.iter_mut().for_each(|span| span.rest_curvature_rad_m = bend);
    }
}

fn add_sections(random: &mut impl Rng, params: &mut RodParams) {
    let (count, length) = (random.random_range(1..13), params.length_m());
    let pitch = length / f64::from(count);
    let (own, saturation_n) = (pitch * random.random_range(0.3..0.95), log(random, 0.3, 50.0));
    let compliance_m_per_n = random.random_range(0.02..0.6) * own / saturation_n;
    params.sections = (0..count)
        .map(|k| CompressibleSection {
            start_m: (f64::from(k) + 0.5) * pitch - 0.5 * own,
            length_m: own,
            compliance_m_per_n,
            saturation_n,
        })
        .collect();
}

/// One to twelve tendons at any angles and distances, that end together or at the ends of up to
/// three segments.
fn add_tendons(random: &mut impl Rng, params: &mut RodParams) {
    let (count, segments, length) =
        (random.random_range(1..13), random.random_range(1..4), params.length_m());
    let compliance = if chance(random, 0.5) { log(random, 1e-7, 1e-3) * length } else { 0.0 };
    let pretension_m =
        if chance(random, 0.2) { random.random_range(-0.002..0.002) * length } else { 0.0 };
    let mut ends: Vec<f64> =
        (1..segments).map(|_| random.random_range(0.05..1.0) * length).collect();
    ends.push(length);
    params.tendons = (0..count)
        .map(|k| {
            let angle: f64 = random.random_range(0.0..std::f64::consts::TAU);
            let offset = random.random_range(0.01..0.1) * length;
            let end_m = ends[k as usize % ends.len()];
            let parallel = Tendon::parallel([offset * angle.cos(), offset * angle.sin()], end_m);
            Tendon { pretension_m, compliance_m_per_n: compliance, ..parallel }
        })
        .collect();
}

fn add_memory(random: &mut impl Rng, params: &mut RodParams) {
    let (stiffness, length) = (bending_n_m2(params), params.length_m());
    let yaml = match random.random_range(0..10) {
        0 => format!(
            "friction: {{moment_nm: {:e}, yield_rad_m: {:e}, coupled: {}}}",
            stiffness / length * log(random, 0.01, 1.0),
            log(random, 0.01, 1.0) / length,
            chance(random, 0.5)
        ),
        1 => format!(
            "hysteresis: {{share: {:e}, range_rad_m: {:e}}}",
            log(random, 0.01, 1.0),
            1.0 / length
        ),
        2 => format!(
            "creep: {{share: {:e}, time_s: {:e}}}",
            log(random, 0.01, 0.8),
            log(random, 0.1, 100.0)
        ),
        _ => return,
    };
    super::effects(&format!("- {yaml}"))[0].build().modify_rod(params);
}

pub fn tip_load(random: &mut impl Rng, params: &RodParams) -> TipWrench {
    let (stiffness, length) = (bending_n_m2(params), params.length_m());
    let mut load = TipWrench::default();
    if chance(random, 0.3) {
        load.force_n = log(random, 0.01, 10.0) * stiffness / (length * length) * direction(random);
    }
    if chance(random, 0.2) {
        load.moment_nm = log(random, 0.01, 5.0) * stiffness / length * direction(random);
    }
    load
}

/// One drive a tendon, by length, by tension or mixed; `angle_rad` says how far they would bend the
/// rod.
pub fn drives(random: &mut impl Rng, params: &RodParams, angle_rad: f64) -> Vec<Drive> {
    let (stiffness, length) = (bending_n_m2(params), params.length_m());
    let (kind, absolute) = (random.random_range(0..5), chance(random, 0.05));
    let drive = |tendon: &Tendon| {
        let ([x, y], _) = tendon.path.at(0.0);
        let offset = x.hypot(y);
        let share: f64 = random.random_range(-1.0..1.0);
        let by_length = kind < 3 || (kind == 4 && chance(random, 0.5));
        match by_length {
            _ if kind == 4 && chance(random, 0.2) => Drive::Follow,
            true if absolute => Drive::Pull(share * length),
            true => Drive::Pull((share * angle_rad * offset).clamp(-length, length)),
            false if absolute => Drive::Tension(500.0 * share.abs()),
            false => Drive::Tension(share * share * angle_rad * stiffness / (length * offset)),
        }
    };
    params.tendons.iter().map(drive).collect()
}
