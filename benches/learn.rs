//! Where the time of learning goes: fits, predictions, an epoch, a step.
//!
//! `cargo bench --bench learn`. The data are made here, with the sizes and shapes of the
//! experiments (seven inputs, three outputs, 0.5 mm of noise); `docs/method/learning.md` holds measured
//! figures.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use rand::RngExt;
use spinebench::base::{Rows, Seed};
use spinebench::learn::gp::{Gp, GpConfig};
use spinebench::learn::networks::{Network, NetworkConfig};

/// A random walk of two bending angles of a constant-curvature robot of 0.22 m: rows of four tendon
/// displacements, three tip coordinates and a smooth residual with noise in three coordinates.
fn walk(count: usize, stride: usize) -> Rows {
    let mut rng = Seed(1).child("walk").rng();
    let mut angles = [0.0_f64; 2];
    let mut rows = Rows::new(10);
    for step in 0..count * stride {
        for angle in &mut angles {
            let next = *angle + rng.random_range(-0.09..0.09);
            *angle = if next.abs() > 1.2 { 2.0 * *angle - next } else { next };
        }
        if step % stride == 0 {
            let [a, b] = angles;
            let bend = a.hypot(b).max(1e-9);
            let reach = 0.22 * (1.0 - bend.cos()) / (bend * bend);
            let tip = [reach * a, reach * b, 0.22 * bend.sin() / bend];
            let mut noise = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>() * 0.0005;
            let gap = [
                0.012 * (0.8 * a).cos() + 0.003 * (2.5 * a + 0.7 * b).sin() + noise(),
                0.004 * (2.0 * b).sin() + 0.003 * a * b + noise(),
                0.003 * (1.5 * a).cos() + 0.002 * (3.0 * a).tanh() + noise(),
            ];
            let row =
                [[0.025 * a, 0.025 * b, -0.025 * a, -0.025 * b].as_slice(), &tip, &gap].concat();
            rows.push(&row);
        }
    }
    rows
}

fn columns(rows: &Rows, which: std::ops::Range<usize>) -> Rows {
    let mut out = Rows::new(which.len());
    rows.iter().for_each(|row| out.push(&row[which.clone()]));
    out
}

fn gaussian_process(c: &mut Criterion) {
    let all = columns(&walk(10_000, 1), 0..7);
    for points in [100, 400, 1000] {
        let rows = walk(points, 10);
        let (inputs, outputs) = (columns(&rows, 0..7), columns(&rows, 7..10));
        for starts in [1, 8] {
            let config = GpConfig { starts, ..GpConfig::default() };
            c.bench_function(&format!("gp_fit_3_outputs/{points}_points_{starts}_starts"), |b| {
                b.iter(|| Gp::fit(black_box(&inputs), &outputs, &config).expect("fit"));
            });
        }
        let gp = Gp::fit(&inputs, &outputs, &GpConfig::default()).expect("fit");
        c.bench_function(&format!("gp_predict_1_mean/{points}_points"), |b| {
            b.iter(|| gp.mean(black_box(all.row(17))).expect("mean"));
        });
        c.bench_function(&format!("gp_predict_1_mean_variance/{points}_points"), |b| {
            b.iter(|| gp.predict(black_box(all.row(17))).expect("prediction"));
        });
        if points == 1000 {
            c.bench_function("gp_predict_10000_mean_variance/1000_points", |b| {
                b.iter(|| gp.predict_rows(black_box(&all)).expect("predictions"));
            });
        }
    }
}

fn elman(c: &mut Criterion) {
    let rows = walk(10_001, 1);
    let now: Vec<usize> = (0..10_000).collect();
    let next: Vec<usize> = (1..10_001).collect();
    let inputs = columns(&rows.select(&now), 0..7);
    let outputs = columns(&rows.select(&next), 4..7);
    let one = NetworkConfig { max_epochs: 1, ..NetworkConfig::default() };
    let cases = [
        ("stride_10_batch_16", one.clone()),
        ("stride_1_batch_64", NetworkConfig { stride: 1, batch: 64, ..one.clone() }),
        ("window_1_batch_64", NetworkConfig { window: 1, stride: 1, batch: 64, ..one.clone() }),
    ];
    for (name, config) in cases {
        c.bench_function(&format!("elman_epoch_7000_rows_with_validation/{name}"), |b| {
            let train =
                || Network::train(&inputs, &outputs, &[], &config, Seed(1)).expect("training");
            b.iter(train);
        });
    }
    c.bench_function("elman_to_convergence/10000_rows", |b| {
        let train = || {
            Network::train(&inputs, &outputs, &[], &NetworkConfig::default(), Seed(1))
                .expect("training")
        };
        b.iter(train);
    });
    let network = Network::train(&inputs, &outputs, &[], &one, Seed(1)).expect("training").network;
    c.bench_function("elman_step", |b| {
        let mut out = [0.0; 3];
        b.iter_batched_ref(
            || network.state(),
            |state| network.step(state, black_box(inputs.row(3)), &mut out).expect("step"),
            BatchSize::SmallInput,
        );
    });
}

criterion_group! {
    name = learn;
    config = Criterion::default().sample_size(10).measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(300));
    targets = gaussian_process, elman
}
criterion_main!(learn);
