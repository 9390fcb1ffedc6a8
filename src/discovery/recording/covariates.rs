//! Covariates of each sample: quantities known from model and commands alone, which residuals are
//! compared with.

use super::samples::Samples;
use crate::base::Rows;

/// Covariates of one sample.
#[derive(Clone, Debug)]
pub(crate) struct Covariates {
    /// Index of the tracked point; none for the tip.
    pub(crate) point: Option<usize>,
    /// Time in the trial, seconds.
    pub(crate) time_s: f64,
    /// Simulated tip or point, metres.
    pub(crate) position_m: [f64; 3],
    /// Displacement since the previous sample, metres.
    pub(crate) moved_m: [f64; 3],
    /// Mean velocity since the previous sample, m/s.
    pub(crate) velocity_m_s: [f64; 3],
    /// Command in force up to this sample.
    pub(crate) command: Vec<f64>,
    /// Change from the command before.
    pub(crate) change: Vec<f64>,
    /// Change of the command before that.
    pub(crate) change_before: Vec<f64>,
    /// Largest command of each tendon in this trial so far.
    pub(crate) largest: Vec<f64>,
}

/// Covariates of all samples, which the model simulates at `simulated_m`.
pub(crate) fn sample_covariates(samples: &Samples, simulated_m: &[f64]) -> Vec<Covariates> {
    let position =
        |row: usize| -> [f64; 3] { std::array::from_fn(|axis| simulated_m[3 * row + axis]) };
    let largest: Vec<Vec<Vec<f64>>> =
        samples.trials.iter().map(|trial| running_maxima(&trial.commands)).collect();
    samples
        .rows
        .iter()
        .enumerate()
        .map(|(index, sample)| {
            let commands = &samples.trials[sample.trial].commands;
            let width = commands.width();
            let command_index = samples.command_of(sample);
            let before = |steps: usize| -> Vec<f64> {
                command_index
                    .and_then(|index| index.checked_sub(steps))
                    .map_or_else(|| vec![0.0; width], |row| commands.row(row).to_vec())
            };
            let (now, last, older) = (before(0), before(1), before(2));
            let difference = |a: &[f64], b: &[f64]| -> Vec<f64> {
                a.iter().zip(b).map(|(a, b)| a - b).collect()
            };
            let since = samples.steps_since_last(index);
            let from = if since.is_some() { position(index - 1) } else { position(index) };
            let moved_m: [f64; 3] = std::array::from_fn(|axis| position(index)[axis] - from[axis]);
            Covariates {
                point: sample.point,
                time_s: sample.time_s,
                position_m: position(index),
                moved_m,
                velocity_m_s: moved_m
                    .map(|moved_m| moved_m / (since.unwrap_or(1.0) * samples.tracked_step_s)),
                change: difference(&now, &last),
                change_before: difference(&last, &older),
                command: now,
                // Maxima have one entry more than commands: before the first there is home.
                largest: largest[sample.trial][command_index.map_or(0, |index| index + 1)].clone(),
            }
        })
        .collect()
}

/// Running maximum of each tendon's command: before the first row, before the second, … after the
/// last.
fn running_maxima(commands: &Rows) -> Vec<Vec<f64>> {
    let mut maxima = vec![vec![0.0; commands.width()]];
    for row in commands.iter() {
        let last = &maxima[maxima.len() - 1];
        maxima.push(
            last.iter().zip(row).map(|(largest, now): (&f64, &f64)| largest.max(*now)).collect(),
        );
    }
    maxima
}
