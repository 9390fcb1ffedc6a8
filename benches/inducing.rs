//! Sparse Gaussian processes beside the exact one: `cargo bench --bench inducing` prints CPU
//! seconds of a fit (three outputs, one thread), of 1,000 predictions with variance, and the mean
//! absolute error on unseen points without noise. `docs/method/learning.md` holds measured figures.

use rand::RngExt;
use spinebench::base::{Rows, Seed};
use spinebench::learn::gp::{Approximation, Gp, GpConfig};

/// Samples of a smooth gap over two bending angles of a constant-curvature robot of 0.22 m: four
/// displacements and the tip, the gap in three coordinates, and the same without 0.5 mm of noise.
fn samples(count: usize, seed: u64) -> [Rows; 3] {
    let mut rng = Seed(seed).child("angles").rng();
    let mut all = [Rows::new(7), Rows::new(3), Rows::new(3)];
    for _ in 0..count {
        let [a, b]: [f64; 2] = std::array::from_fn(|_| rng.random_range(-1.2..1.2));
        let bend = a.hypot(b).max(1e-9);
        let reach = 0.22 * (1.0 - bend.cos()) / (bend * bend);
        let tip = [reach * a, reach * b, 0.22 * bend.sin() / bend];
        let mut noise = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>() * 0.0005;
        let gap = [
            0.012 * (0.8 * a).cos() + 0.003 * (2.5 * a + 0.7 * b).sin(),
            0.004 * (2.0 * b).sin() + 0.003 * a * b,
            0.003 * (1.5 * a).cos() + 0.002 * (3.0 * a).tanh(),
        ];
        all[0].push(&[[0.025 * a, 0.025 * b, -0.025 * a, -0.025 * b].as_slice(), &tip].concat());
        all[1].push(&gap.map(|gap| gap + noise()));
        all[2].push(&gap);
    }
    all
}

/// As [`samples`], of a rugged function of seven independent inputs: what no 200 points can hold.
fn rugged(count: usize, seed: u64) -> [Rows; 3] {
    let mut rng = Seed(seed).child("rugged").rng();
    let mut all = [Rows::new(7), Rows::new(3), Rows::new(3)];
    for _ in 0..count {
        let x: [f64; 7] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let mut noise = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>() * 0.0005;
        let gap = [
            0.006 * (2.0 * x[0] + x[1]).sin() * (1.5 * x[2]).cos(),
            0.006 * (2.0 * x[3] - x[4]).sin() + 0.004 * (2.5 * x[0] * x[5]).sin(),
            0.006 * (1.5 * x[6] + x[1]).cos() * (2.0 * x[3]).sin(),
        ];
        all[0].push(&x);
        all[1].push(&gap.map(|gap| gap + noise()));
        all[2].push(&gap);
    }
    all
}

/// CPU time of this thread's process, seconds.
fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks = |place: usize| {
        after.split_whitespace().nth(place).and_then(|value| value.parse::<f64>().ok())
    };
    (ticks(11).unwrap_or(f64::NAN) + ticks(12).unwrap_or(f64::NAN)) / 100.0
}

type Samples = fn(usize, u64) -> [Rows; 3];

fn main() {
    println!("data    points  process         fit_s  predict_1000_s  error_mm");
    for (name, samples) in [("robot", samples as Samples), ("rugged", rugged as Samples)] {
        [1000, 4000, 10_000].into_iter().for_each(|points| compare(name, samples, points));
    }
}

fn compare(data: &str, samples: Samples, points: usize) {
    let [queries, _, truth] = samples(2000, 2);
    let [inputs, outputs, _] = samples(points, 1);
    for (approximation, inducing_points) in [
        (Approximation::Exact, 200),
        (Approximation::Sgpr, 100),
        (Approximation::Sgpr, 200),
        (Approximation::Sgpr, 500),
        (Approximation::Fitc, 200),
    ] {
        if approximation == Approximation::Exact && points > 4000 {
            continue;
        }
        let config = GpConfig { approximation, inducing_points, ..GpConfig::default() };
        let start = cpu_s();
        let gp = Gp::fit(&inputs, &outputs, &config).unwrap();
        let fitted = cpu_s();
        let found = gp.predict_rows(&queries).unwrap();
        let done = cpu_s();
        let apart = found.mean.values().iter().zip(truth.values()).map(|(a, b)| (a - b).abs());
        let error_mm = 1000.0 * apart.sum::<f64>() / truth.values().len() as f64;
        let name = match approximation {
            Approximation::Exact => "exact".to_owned(),
            Approximation::Sgpr => format!("sgpr, {inducing_points}"),
            Approximation::Fitc => format!("fitc, {inducing_points}"),
        };
        println!(
            "{data:6}  {points:6}  {name:12}  {:7.2}  {:14.3}  {error_mm:.5}",
            fitted - start,
            (done - fitted) / 2.0
        );
    }
}
