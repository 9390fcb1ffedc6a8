//! The samples that all learn from, made by our own robot and handed to the packages as files of
//! numbers.

use std::path::Path;

use rand_distr::{Distribution, Normal};
use spinebench::base::{Rows, Seed};
use spinebench::effects::Model;
use spinebench::plants::{Simulated, SimulatedOptions};
use spinebench::specs;
use spinebench::tasks::{ExploreOptions, Transitions, explore};

use super::task::SIZES;

/// Steps of each exploration.
const STEPS: usize = 10_000;
/// Standard deviation of the tracking noise, metres.
const NOISE_M: f64 = 0.0005;
/// Largest pull of the exploration for networks, metres: within it networks of 30 units reach the
/// error that they are trained to.
const NETWORK_PULL_M: f64 = 0.010;
/// Share of the rows that a network is trained on.
const TRAINED: f64 = 0.7;

/// All samples.
pub struct Samples {
    pub processes: Vec<ProcessSamples>,
    pub network: NetworkSamples,
}

/// Samples of one size for Gaussian processes, in standard deviations of the samples.
pub struct ProcessSamples {
    pub size: usize,
    /// Four tendons and the simulated tip.
    pub inputs: Rows,
    /// Simulated minus measured tip.
    pub outputs: Rows,
    /// Inputs of another exploration.
    pub queries: Rows,
    /// What is to be predicted there, without noise.
    pub truth: Rows,
    /// Standard deviation of each output, metres.
    pub scale_m: Vec<f64>,
}

/// Rows for the forward model (tendons, tip) → next tip, in standard deviations of the rows that
/// are trained on.
pub struct NetworkSamples {
    pub inputs: Rows,
    pub outputs: Rows,
    /// The outputs in metres.
    pub outputs_m: Rows,
    /// Standard deviation of each output, metres.
    pub scale_m: Vec<f64>,
}

impl NetworkSamples {
    /// Rows that are trained on.
    pub fn trained(&self) -> usize {
        (TRAINED * self.inputs.len() as f64).round() as usize
    }
}

/// One exploration: inputs, and what the model is made to lack.
struct Exploration {
    inputs: Rows,
    gap_m: Rows,
}

impl Samples {
    /// Explores the nominal robot with steps of at most 3 mm: once for samples, once for queries,
    /// once for networks.
    ///
    /// # Errors
    /// A model that cannot be read, a robot that fails.
    pub fn make(root: &Path) -> Result<Samples, String> {
        let model = specs::read_model(&root.join("models/nominal.yaml"))
            .map_err(|error| error.to_string())?;
        let pull_m = ExploreOptions::default().max_pull_m;
        let explorations = [("samples", pull_m), ("queries", pull_m), ("network", NETWORK_PULL_M)];
        let walks = std::thread::scope(|scope| {
            let model = &model;
            let threads =
                explorations.map(|(name, pull_m)| scope.spawn(move || walk(model, pull_m, name)));
            threads
                .map(|thread| thread.join().unwrap_or_else(|_| Err("the robot failed".to_owned())))
        });
        let [pool, test, network] = walks;
        let (pool, test) = (Exploration::of(&pool?), Exploration::of(&test?));
        let processes = SIZES.iter().map(|&size| ProcessSamples::new(size, &pool, &test)).collect();
        Ok(Samples { processes, network: NetworkSamples::of(network?) })
    }

    /// Writes what the scripts read.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), String> {
        let file = |name: String, rows: &Rows| {
            let line =
                |row: &[f64]| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n";
            let path = folder.join(name + ".csv");
            let text: String = rows.iter().map(line).collect();
            std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
        };
        let one = |values: &[f64]| {
            let mut rows = Rows::new(values.len());
            rows.push(values);
            rows
        };
        for own in &self.processes {
            let name = |kind: &str| format!("gp_{}_{kind}", own.size);
            file(name("inputs"), &own.inputs)?;
            file(name("outputs"), &own.outputs)?;
            file(name("queries"), &own.queries)?;
            file(name("truth"), &own.truth)?;
            file(name("scale"), &one(&own.scale_m))?;
        }
        file("elman_inputs".into(), &self.network.inputs)?;
        file("elman_outputs".into(), &self.network.outputs)?;
        file("elman_scale".into(), &one(&self.network.scale_m))?;
        file("elman_target".into(), &one(&[super::ours::TARGET_M]))
    }
}

impl Exploration {
    fn of(walk: &Transitions) -> Exploration {
        let mut gap_m = Rows::new(3);
        for pulls_m in walk.pulls_m.iter() {
            // Bending angles of a robot whose tendons run 2 cm from its axis.
            let [a, b] = [pulls_m[0] / 0.02, pulls_m[1] / 0.02];
            gap_m.push(&[
                0.010 * (0.9 * a).cos() * (0.5 * b).cos() + 0.002 * (2.0 * a + b).sin(),
                0.004 * (1.8 * b).sin() + 0.003 * a * b,
                0.003 * ((1.4 * a).cos() - (1.1 * b).cos()) + 0.002 * (2.5 * a).tanh(),
            ]);
        }
        Exploration { inputs: beside(&walk.pulls_m, &walk.to_m), gap_m }
    }
}

impl ProcessSamples {
    /// `size` samples evenly over `pool`, with noise; all of `test` as queries.
    fn new(size: usize, pool: &Exploration, test: &Exploration) -> ProcessSamples {
        let which: Vec<usize> = (0..size).map(|i| (2 * i + 1) * STEPS / (2 * size)).collect();
        let mut random = Seed(1).child("peers").child("noise").rng();
        let noise = Normal::new(0.0, NOISE_M).expect("a positive deviation");
        let mut noisy_m = Rows::new(3);
        pool.gap_m.iter().for_each(|row| {
            noisy_m.push(&[0, 1, 2].map(|axis| row[axis] + noise.sample(&mut random)))
        });
        let (inputs, outputs) = (pool.inputs.select(&which), noisy_m.select(&which));
        let (of_inputs, of_outputs) = (Scale::of(&inputs), Scale::of(&outputs));
        ProcessSamples {
            size,
            inputs: of_inputs.apply(&inputs),
            outputs: of_outputs.apply(&outputs),
            queries: of_inputs.apply(&test.inputs),
            truth: of_outputs.apply(&test.gap_m),
            scale_m: of_outputs.deviations,
        }
    }
}

impl NetworkSamples {
    fn of(seen: Transitions) -> NetworkSamples {
        let (inputs, outputs_m) = (beside(&seen.pulls_m, &seen.from_m), seen.to_m);
        let trained: Vec<usize> = (0..(TRAINED * STEPS as f64).round() as usize).collect();
        let (of_inputs, of_outputs) =
            (Scale::of(&inputs.select(&trained)), Scale::of(&outputs_m.select(&trained)));
        NetworkSamples {
            inputs: of_inputs.apply(&inputs),
            outputs: of_outputs.apply(&outputs_m),
            outputs_m,
            scale_m: of_outputs.deviations,
        }
    }
}

fn walk(model: &Model, max_pull_m: f64, name: &str) -> Result<Transitions, String> {
    let options = ExploreOptions { points: STEPS, max_pull_m, ..ExploreOptions::default() };
    let mut robot = Simulated::new(model, &[], SimulatedOptions::default());
    explore(&mut robot, &options, Seed(1).child("peers").child(name))
        .map_err(|error| error.to_string())
}

/// Tables of the same length side by side.
fn beside(left: &Rows, right: &Rows) -> Rows {
    let mut out = Rows::new(left.width() + right.width());
    left.iter().zip(right.iter()).for_each(|(left, right)| out.push(&[left, right].concat()));
    out
}

/// Mean and (population) standard deviation of each column.
struct Scale {
    means: Vec<f64>,
    deviations: Vec<f64>,
}

impl Scale {
    fn of(rows: &Rows) -> Scale {
        let count = rows.len() as f64;
        let each = |c: usize| rows.iter().map(move |row| row[c]);
        let means: Vec<f64> = (0..rows.width()).map(|c| each(c).sum::<f64>() / count).collect();
        let square =
            |c: usize| each(c).map(|value| (value - means[c]).powi(2)).sum::<f64>() / count;
        Scale { deviations: (0..rows.width()).map(|c| square(c).sqrt()).collect(), means }
    }

    fn apply(&self, rows: &Rows) -> Rows {
        let mut out = Rows::new(rows.width());
        for row in rows.iter() {
            let scaled: Vec<f64> = row
                .iter()
                .enumerate()
                .map(|(c, value)| (value - self.means[c]) / self.deviations[c])
                .collect();
            out.push(&scaled);
        }
        out
    }
}
