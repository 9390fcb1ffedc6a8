//! Models at the edges of their ranges: every step ends converged or with a named status, with
//! finite numbers, after a bounded effort.

use spinebench::base::{Plant, PlantError, Seed};
use spinebench::effects::Model;
use spinebench::plants::{Simulated, SimulatedOptions};
use spinebench::rod::SolveStatus;

fn nominal() -> Model {
    let text = include_str!("../../models/nominal.yaml");
    serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text))
        .unwrap()
}

/// Iterations of Newton's method for a trial of four commands: the hardest of the cases below takes
/// 2,000.
const MAX_ITERATIONS: u64 = 10_000;

/// A name and what is changed of the nominal model.
type Case = (&'static str, fn(&mut Model));

/// Counts of what converged and what failed by name, in lengths and in tensions, at rest and
/// moving.
fn torture(name: &str, model: &Model) -> (usize, usize) {
    model.check().unwrap_or_else(|error| panic!("{name}: {error:?}"));
    let options = SimulatedOptions { travel_m: f64::INFINITY, ..SimulatedOptions::default() };
    let mut plant = Simulated::new(model, &[], options);
    let tendons = plant.tendons();
    let reach_m = 2.0 * model.robot.backbone.length_m;
    let (mut solved, mut failed, mut iterations) = (0, 0, 0);
    let mut count = |outcome: Result<spinebench::base::Observation, PlantError>| match outcome {
        Ok(seen) => {
            assert!(seen.tip_m.iter().all(|x| x.is_finite()), "{name}: {seen:?}");
            let distance_m = seen.tip_m.iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!(distance_m < reach_m, "{name}: {seen:?}");
            let tensions = seen.tensions_n.unwrap();
            assert!(
                tensions.iter().all(|tension| tension.is_finite() && *tension >= 0.0),
                "{name}: {tensions:?}"
            );
            assert!(seen.pulls_m.iter().all(|x| x.is_finite()), "{name}");
            solved += 1;
            true
        }
        Err(PlantError::Solver(status)) => {
            assert!(
                SolveStatus::ALL.iter().any(|known| known.name() == status),
                "{name}: {status}"
            );
            failed += 1;
            false
        }
        Err(other) => panic!("{name}: {other}"),
    };
    for k in 0..4 {
        let mut pulls = vec![0.0; tendons];
        pulls[k % tendons] = 0.01;
        pulls[(k + tendons / 2) % tendons] = if tendons == 1 { 0.01 } else { -0.01 };
        if count(plant.reset(Seed(1))) {
            for _ in 0..3 {
                if !count(plant.step(&pulls)) {
                    break;
                }
            }
            count(plant.step(&vec![0.0; tendons]));
        }
        iterations = plant.rod().effort().iterations.max(iterations);
        let mut tensions = vec![0.0; tendons];
        tensions[k % tendons] = 5.0;
        plant.reset_slack(Seed(1));
        if count(plant.apply_tensions(&tensions, true)) {
            count(plant.apply_tensions(&vec![0.0; tendons], false));
        }
        iterations = plant.rod().effort().iterations.max(iterations);
    }
    println!("{name:28} {solved:3} converged {failed:3} failed {iterations:6} iterations");
    assert!(iterations < MAX_ITERATIONS, "{name}: {iterations} iterations");
    (solved, failed)
}

/// Changes that leave a robot which a good solver must manage: none of its solves may fail.
#[test]
fn unusual_robots_are_solved() {
    let cases: &[Case] = &[
        ("nominal", |_| {}),
        ("one tendon", |m| m.robot.tendons.angles_deg = vec![30.0]),
        ("three tendons", |m| m.robot.tendons.angles_deg = vec![0.0, 120.0, 240.0]),
        ("twelve tendons", |m| {
            m.robot.tendons.angles_deg = (0..12).map(|k| 30.0 * f64::from(k)).collect()
        }),
        ("tendons end part-way", |m| m.robot.tendons.ends_m = Some(vec![0.11, 0.11, 0.22, 0.22])),
        ("no sections", |m| m.robot.sections.count = 0),
        ("no disks", |m| m.robot.disks.count = 0),
        ("no gravity", |m| m.robot.gravity_m_s2 = [0.0; 3]),
        ("massless", |m| {
            m.robot.disks.count = 0;
            m.robot.backbone.density_kg_m3 = 0.0;
        }),
        ("massless and undamped", |m| {
            m.robot.disks.count = 0;
            m.robot.backbone.density_kg_m3 = 0.0;
            m.robot.damping_time_s = 0.0;
        }),
        ("pretension 5 mm", |m| m.robot.tendons.pretension_m = 0.005.into()),
        ("slack at home", |m| m.robot.tendons.pretension_m = (-0.005).into()),
        ("elastic tendons", |m| m.robot.tendons.compliance_m_per_n = 1e-3.into()),
        ("undamped", |m| m.robot.damping_time_s = 0.0),
        ("heavily damped", |m| m.robot.damping_time_s = 100.0),
        ("drag", |m| m.robot.drag_n_s2_m3 = 10.0),
        ("2 m long", |m| {
            m.robot.backbone = spinebench::effects::Backbone {
                length_m: 2.0,
                radius_m: 0.01,
                ..m.robot.backbone.clone()
            }
        }),
        ("stiff", |m| m.robot.backbone.youngs_modulus_pa = 2e11),
        ("tilted", |m| m.robot.base_rotation_rad = [0.0, 3.0, 0.5]),
    ];
    let failed: Vec<&str> = cases
        .iter()
        .filter(|(name, change)| case(name, *change).1 > 0)
        .map(|case| case.0)
        .collect();
    assert!(failed.is_empty(), "{failed:?}");
}

/// Changes beyond what such a robot can be: whatever happens has a name.
#[test]
fn impossible_robots_end_with_a_named_status() {
    let cases: &[Case] = &[
        ("jelly", |m| m.robot.backbone.youngs_modulus_pa = 1e3),
        ("barely solid", |m| m.robot.backbone.youngs_modulus_pa = 1e-300),
        ("beyond diamond", |m| m.robot.backbone.youngs_modulus_pa = 1e18),
        ("infinitely stiff", |m| m.robot.backbone.youngs_modulus_pa = 1e300),
        ("a hair", |m| m.robot.backbone.radius_m = 1e-4),
        ("a point", |m| m.robot.backbone.radius_m = 1e-90),
        ("saturates at once", |m| m.robot.sections.saturation_n = 1e-6),
        ("2 m on the thin backbone", |m| m.robot.backbone.length_m = 2.0),
        ("shorter than a micrometre", |m| {
            m.robot.backbone.length_m = 1e-7;
            m.robot.sections.count = 0;
            m.robot.disks.count = 0;
        }),
        ("tendon ends at the base", |m| {
            m.robot.tendons.ends_m = Some(vec![1e-9, 0.22, 0.22, 0.22])
        }),
        ("tendons far out", |m| m.robot.tendons.radius_m = 10.0),
        ("tendons on the axis", |m| m.robot.tendons.radius_m = 1e-12),
        ("on Jupiter's big brother", |m| m.robot.gravity_m_s2 = [-1e6, 0.0, 0.0]),
        ("gravity overflows", |m| m.robot.gravity_m_s2 = [-1e308, 0.0, 0.0]),
        ("lead disks", |m| m.robot.disks.mass_kg = 100.0),
        ("drag of a swamp", |m| m.robot.drag_n_s2_m3 = 1e6),
        ("pretension of a metre", |m| m.robot.tendons.pretension_m = 1.0.into()),
        ("one mode", |m| {
            m.robot.resolution.bending_modes = 1;
            m.robot.resolution.torsion_modes = 1;
            m.robot.resolution.shear_modes = 1;
            m.robot.resolution.axial_modes = 1;
        }),
        ("one cell", |m| {
            m.robot.resolution.cell_m = 1.0;
            m.robot.sections.count = 0;
            m.robot.disks.count = 0;
        }),
    ];
    for (name, change) in cases {
        case(name, *change);
    }
}

fn case(name: &str, change: fn(&mut Model)) -> (usize, usize) {
    let mut model = nominal();
    change(&mut model);
    torture(name, &model)
}
