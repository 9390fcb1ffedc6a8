//! The rod against recordings of an independent simulator (a MuJoCo hinge chain with the nominal numbers).

mod common;

use spinebench::base::{Plant, Seed};
use spinebench::effects::{EffectSpec, Model};
use spinebench::plants::{Simulated, SimulatedOptions};
use spinebench::rod::Scheme;

fn nominal() -> Model {
    let text = include_str!("../models/nominal.yaml");
    serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text)).unwrap()
}

/// Per-axis root mean square distance between model and recording, and between their static home poses.
fn rms_m(model: &Model, extra: &[EffectSpec], file: &str, dt: f64, scheme: Scheme) -> ([f64; 3], f64) {
    let rows = common::read(&format!("tests/reference/twin/{file}.csv"));
    let mut model = model.clone();
    model.robot.resolution.time_step_s = dt;
    model.robot.resolution.scheme = scheme;
    let mut plant = Simulated::new(&model, extra, SimulatedOptions::default());
    let mut sum = [0.0; 3];
    let mut seen = plant.reset(Seed(0)).unwrap();
    let mut trial = 0.0;
    for row in &rows {
        if row["trial"] != trial {
            trial = row["trial"];
            seen = plant.reset(Seed(0)).unwrap();
        }
        for (axis, name) in ["tip_x_m", "tip_y_m", "tip_z_m"].iter().enumerate() {
            sum[axis] += (seen.tip_m[axis] - row[*name]).powi(2);
        }
        let pulls: Vec<f64> = (1..=4).map(|i| row[&format!("tendon_{i}_m")]).collect();
        seen = plant.step(&pulls).unwrap();
    }
    let each = sum.map(|s| (s / rows.len() as f64).sqrt());
    (each, each.iter().map(|e| e * e).sum::<f64>().sqrt())
}

#[test]
fn explore() {
    let model = nominal();
    for (scheme, dt) in [
        (Scheme::Sdirk2, 0.2),
        (Scheme::Sdirk2, 0.1),
        (Scheme::Sdirk2, 0.05),
        (Scheme::Sdirk2, 0.02),
        (Scheme::Sdirk2, 0.01),
        (Scheme::Sdirk2, 0.002),
        (Scheme::Euler, 0.02),
        (Scheme::Euler, 0.1),
        (Scheme::Sdirk3, 0.05),
    ] {
        let start = std::time::Instant::now();
        let (each, all) = rms_m(&model, &[], "baseline", dt, scheme);
        let took = start.elapsed().as_secs_f64();
        println!(
            "{scheme:?} {dt}: {:.3} mm, {:?} mm; {took:.3} s, real-time factor {:.0}",
            all * 1e3,
            each.map(|e| (e * 1e5).round() / 100.0),
            400.0 * 0.2 / took
        );
    }
}

#[test]
fn effort() {
    let rows = common::read("tests/reference/twin/baseline.csv");
    let mut model = nominal();
    model.robot.resolution.time_step_s = 0.05;
    let mut plant = Simulated::new(&model, &[], SimulatedOptions::default());
    plant.reset(Seed(0)).unwrap();
    let start = std::time::Instant::now();
    let (i0, f0) = plant.rod().effort();
    for row in std::iter::repeat_n(&rows[..50], 20).flatten() {
        let pulls: Vec<f64> = (1..=4).map(|i| row[&format!("tendon_{i}_m")]).collect();
        plant.step(&pulls).unwrap();
    }
    let (i1, f1) = plant.rod().effort();
    println!(
        "per tick: {:.1} iterations {:.1} factorisations, {:.0} us",
        (i1 - i0) as f64 / 1000.0,
        (f1 - f0) as f64 / 1000.0,
        start.elapsed().as_secs_f64() * 1e6 / 1000.0
    );
}
