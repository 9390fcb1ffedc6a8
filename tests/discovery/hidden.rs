//! Recordings in which something is hidden, and what is said of them.

use std::path::Path;

use spinebench::base::Seed;
use spinebench::benchmark;
use spinebench::data::Recording;
use spinebench::discovery::{Discovery, Options, discover};
use spinebench::effects::Model;
use spinebench::tasks::{ExploreOptions, SimulationOptions, simulate_recording};

pub(super) const NOISE_M: f64 = 5e-4;

pub(super) fn nominal() -> Model {
    crate::support::rods::model("nominal")
}

pub(super) fn twin(name: &str) -> Recording {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/reference/twin/{name}.csv"));
    Recording::read(&file).unwrap()
}

/// A recording of the project's own chain in another simulator (docs/evidence/twin.md).
pub(super) fn chain(file: &str) -> Recording {
    Recording::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/twin").join(file))
        .unwrap()
}

/// A recording of a blind benchmark, as the benchmark presents it.
pub(super) fn from_benchmark(file: &str) -> Recording {
    Recording::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/blind").join(file))
        .unwrap()
}

/// The trials of `recording` from number `first` on, so many of them.
pub(super) fn trials(recording: &Recording, first: usize, count: usize) -> Recording {
    let rows: Vec<usize> =
        recording.trials().into_iter().skip(first).take(count).flat_map(|(_, rows)| rows).collect();
    part(recording, &rows)
}

/// These rows of `recording`.
pub(super) fn part(recording: &Recording, rows: &[usize]) -> Recording {
    let mut part = Recording::new(recording.actuation, recording.tendons());
    part.trial = rows.iter().map(|&row| recording.trial[row]).collect();
    part.time_s = rows.iter().map(|&row| recording.time_s[row]).collect();
    part.commands = recording.commands.select(rows);
    part.tip_m = recording.tip_m.as_ref().map(|tips| rows.iter().map(|&row| tips[row]).collect());
    part
}

/// A recording of a robot with `effects` under the twin's commands, on a finer grid and with finer
/// steps than the model's, and with noise of a correlation.
pub(super) fn recorded(effects: &str, count: usize, seed: u64, correlation: f64) -> Recording {
    let mut truth = nominal();
    truth.effects = crate::support::rods::effects(effects);
    truth.robot.resolution.cell_m = 0.008;
    truth.robot.resolution.motion_tolerance_m = 2e-5;
    let commands = trials(&twin("nothing"), 0, count);
    let recording = simulate_recording(&truth, &commands, &SimulationOptions::default());
    with_noise(recording, seed, correlation)
}

fn with_noise(mut recording: Recording, seed: u64, correlation: f64) -> Recording {
    let counts: Vec<usize> = recording.trials().into_iter().map(|(_, rows)| rows.len()).collect();
    let tips_m = recording.tip_m.as_mut().unwrap();
    benchmark::add_noise(tips_m, counts.into_iter(), NOISE_M, correlation, Seed(seed));
    recording.tip_quaternion = None;
    recording
}

/// A recording under commands as the paper explores, of a robot with `effects`, with noise.
pub(super) fn explored(effects: &str, trials: usize, seed: u64) -> Recording {
    explored_in(effects, trials, 50, seed)
}

/// The same in trials of so many steps.
pub(super) fn explored_in(effects: &str, trials: usize, steps: usize, seed: u64) -> Recording {
    let options = ExploreOptions {
        points: steps * trials,
        trajectories: trials,
        ..ExploreOptions::default()
    };
    let commands = benchmark::explore_commands(&nominal(), &options, 0.2, Seed(seed)).unwrap();
    let presented = benchmark::PublicCase {
        tips_m: commands.tips_m(&nominal(), &crate::support::rods::effects(effects)).unwrap(),
        commands,
        left_out: Vec::new(),
    };
    with_noise(presented.recording(), seed, 0.0)
}

pub(super) fn found(measured: &Recording, options: &Options) -> Discovery {
    discover(&nominal(), measured, None, options).unwrap()
}

pub(super) fn names(found: &Discovery) -> Vec<&str> {
    found.findings.effects.iter().map(|effect| effect.name.as_str()).collect()
}

pub(super) fn sorted_names(found: &Discovery) -> Vec<&str> {
    let mut names = names(found);
    names.sort_unstable();
    names
}

/// The value of a parameter and its interval.
pub(super) fn told(found: &Discovery, parameter: &str) -> (f64, [f64; 2]) {
    let effect = &found.findings.effects[0];
    let interval = &effect.interval_95[parameter];
    (effect.parameters[parameter].as_f64().unwrap(), [0, 1].map(|k| interval[k].as_f64().unwrap()))
}
