//! Where the rod's time goes: a static solve, a control step, and a stretch of exploration.
#![allow(missing_docs)]

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use spinebench::base::{Plant, Seed};
use spinebench::effects::Model;
use spinebench::plants::{Simulated, SimulatedOptions};
use spinebench::rod::{Drive, Rod, Status};
use spinebench::tasks::{ExploreOptions, explore};

fn model(text: &str) -> Model {
    serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text)).unwrap()
}

fn rod(criterion: &mut Criterion) {
    let nominal = model(include_str!("../models/nominal.yaml"));
    let real = model(include_str!("../models/real.yaml"));
    let pulls = |x: f64, y: f64| [x, y, -x, -y].map(Drive::Pull);
    let fresh = Rod::new(nominal.rod(&[]));

    criterion.bench_function("static length control, from straight", |bench| {
        let solve = |mut rod: Rod| assert_eq!(rod.settle(&pulls(0.015, 0.01)), Status::Converged);
        bench.iter_batched(|| fresh.clone(), solve, BatchSize::SmallInput);
    });
    criterion.bench_function("static length control, 1 mm further", |bench| {
        let mut rod = fresh.clone();
        let mut further = false;
        bench.iter(|| {
            further = !further;
            assert_eq!(rod.settle(&pulls(if further { 0.016 } else { 0.015 }, 0.01)), Status::Converged);
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
    criterion.bench_function("exploration, 1,000 steps", |bench| {
        let options = ExploreOptions { points: 1000, ..ExploreOptions::default() };
        let mut plant = Simulated::new(&nominal, &[], SimulatedOptions::default());
        bench.iter(|| black_box(explore(&mut plant, &options, Seed(1)).unwrap()));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(Duration::from_secs(3));
    targets = rod
}
criterion_main!(benches);
