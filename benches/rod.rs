//! Where the rod's time goes: a static solve, a control step, and a stretch of exploration.
#![allow(missing_docs)]

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use spinebench::base::{Plant, Seed};
use spinebench::effects::Model;
use spinebench::plants::{Simulated, SimulatedOptions};
use spinebench::rod::{Drive, Rod, SolveStatus};
use spinebench::tasks::{ExploreOptions, explore, explore_trajectory};

fn model(text: &str) -> Model {
    serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text))
        .unwrap()
}

fn rod(criterion: &mut Criterion) {
    let nominal = model(include_str!("../models/nominal.yaml"));
    let real = model(include_str!("../models/real.yaml"));
    let pulls = |x: f64, y: f64| [x, y, -x, -y].map(Drive::Pull);
    let fresh = Rod::new(nominal.rod(&[]));

    criterion.bench_function("static length control, from straight", |bench| {
        // The rod is given back, so that taking it down is not part of the time.
        let solve = |mut rod: Rod| {
            assert_eq!(rod.settle(&pulls(0.015, 0.01)), SolveStatus::Converged);
            rod
        };
        bench.iter_batched(|| fresh.clone(), solve, BatchSize::SmallInput);
    });
    criterion.bench_function("static length control, 1 mm further", |bench| {
        let mut rod = fresh.clone();
        let mut further = false;
        bench.iter(|| {
            further = !further;
            assert_eq!(
                rod.settle(&pulls(if further { 0.016 } else { 0.015 }, 0.01)),
                SolveStatus::Converged
            );
        });
    });
    for (name, model) in [("nominal", &nominal), ("real", &real)] {
        criterion.bench_function(&format!("control step of 0.2 s, {name}"), |bench| {
            let mut plant = Simulated::new(model, &[], SimulatedOptions::default());
            plant.reset(Seed(1)).unwrap();
            let mut further = false;
            bench.iter(|| {
                further = !further;
                let x = if further { 0.012 } else { 0.010 };
                black_box(plant.step(&[x, 0.005, -x, -0.005]).unwrap())
            });
        });
    }
    collections(criterion, &nominal);
}

/// A collection in one continuous exploration, and in independent ones on two threads.
fn collections(criterion: &mut Criterion, model: &Model) {
    criterion.bench_function("exploration, 1,000 points, one thread", |bench| {
        let options = ExploreOptions { points: 1000, ..ExploreOptions::default() };
        let mut plant = Simulated::new(model, &[], SimulatedOptions::default());
        bench.iter(|| black_box(explore(&mut plant, &options, Seed(1)).unwrap()));
    });
    criterion.bench_function(
        "exploration, 10,000 points in 20 trajectories, two threads",
        |bench| {
            let options =
                ExploreOptions { points: 10_000, trajectories: 20, ..ExploreOptions::default() };
            let own = |first: usize| {
                let mut plant = Simulated::new(model, &[], SimulatedOptions::default());
                for index in (first..options.trajectories).step_by(2) {
                    black_box(explore_trajectory(&mut plant, &options, Seed(1), index).unwrap());
                }
            };
            bench.iter(|| {
                std::thread::scope(|threads| {
                    threads.spawn(|| own(0));
                    own(1);
                });
            });
        },
    );
}

/// A control step of the nominal robot with more Gauss points, more tendons, or more segments with
/// tendons of their own.
fn scaling(criterion: &mut Criterion) {
    let nominal = model(include_str!("../models/nominal.yaml"));
    let mut step = |name: String, robot: Model| {
        let tendons = robot.robot.tendons.angles_deg.len();
        let pulls = |x: f64| -> Vec<Drive> {
            (0..tendons).map(|i| Drive::Pull(if i % 4 == 0 { x } else { 0.0 })).collect()
        };
        let mut rod = Rod::new(robot.rod(&[]));
        assert_eq!(rod.settle(&pulls(0.01)), SolveStatus::Converged);
        let mut x = 0.01;
        criterion.bench_function(&name, |bench| {
            bench.iter(|| {
                let (from, to) = (x, if x > 0.01 { 0.01 } else { 0.011 });
                x = to;
                let ramp = |t: f64| pulls(from + (to - from) * t / 0.02);
                assert_eq!(rod.advance_with(&ramp, 0.02), SolveStatus::Converged);
                assert_eq!(rod.advance(&pulls(to), 0.18), SolveStatus::Converged);
            });
        });
    };
    for cell_m in [0.02, 0.005, 0.0025, 0.00125] {
        let mut robot = nominal.clone();
        robot.robot.resolution.cell_m = cell_m;
        step(format!("control step, cells of {} mm", cell_m * 1e3), robot);
    }
    for count in [4, 8, 16, 32] {
        let mut robot = nominal.clone();
        robot.robot.tendons.angles_deg =
            (0..count).map(|i| 360.0 * f64::from(i) / f64::from(count)).collect();
        step(format!("control step, {count} tendons"), robot);
    }
    for segments in [1_u32, 2, 4] {
        let mut robot = nominal.clone();
        let tendons = &mut robot.robot.tendons;
        tendons.angles_deg = [0.0, 90.0, 180.0, 270.0].repeat(segments as usize);
        let end =
            |i: u32| robot.robot.backbone.length_m * f64::from(i / 4 + 1) / f64::from(segments);
        tendons.ends_m = Some((0..4 * segments).map(end).collect());
        step(format!("control step, {segments} segments of 4 tendons"), robot);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(Duration::from_secs(3));
    targets = rod, scaling
}
criterion_main!(benches);
