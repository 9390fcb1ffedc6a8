//! The noise floor from the data themselves: every trial starts at rest at home, so its first rows are repeats of one
//! measurement; commands that are held show the tip at rest.

use super::noise::Noise;
use super::samples::Samples;
use crate::math::distribution::f_above;

/// An estimate of noise.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Floor {
    /// Variance along x, y and z, m².
    pub(super) variance_m2: [f64; 3],
    /// Degrees of freedom behind each of them.
    pub(super) freedom: f64,
    /// What it was estimated from.
    pub(super) from: String,
}

/// A command is at rest once it has been held for so long, seconds.
const SETTLED_S: f64 = 1.0;

impl Floor {
    /// From repeats of the first row and from rests; no degrees of freedom where there are neither.
    pub(super) fn of_repeats(samples: &Samples) -> Floor {
        let groups = groups(samples);
        let mut variance_m2 = [0.0; 3];
        let mut freedom = 0.0;
        for group in groups.iter().filter(|group| group.len() > 1) {
            freedom += group.len() as f64 - 1.0;
            for (axis, sum) in variance_m2.iter_mut().enumerate() {
                let values: Vec<f64> = group.iter().map(|&row| samples.rows[row].tip_m[axis]).collect();
                let mean = crate::math::summary::mean(&values);
                *sum += values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
            }
        }
        variance_m2.iter_mut().for_each(|sum| *sum /= f64::max(freedom, 1.0));
        let repeated = groups.iter().filter(|group| group.len() > 1);
        let (starts, rests): (Vec<&Vec<usize>>, Vec<&Vec<usize>>) =
            repeated.partition(|group| is_start(samples, group));
        let [firsts, rests] = [starts, rests].map(|groups| groups.iter().map(|group| group.len()).sum::<usize>());
        let from = match (firsts > 1, rests > 1) {
            (true, true) => format!("{firsts} starts at home and {rests} samples at rest"),
            (true, false) => format!("{firsts} starts at home"),
            (false, true) => format!("{rests} samples at rest"),
            (false, false) => "the residual alone: nothing was measured twice".to_owned(),
        };
        Floor { variance_m2, freedom, from }
    }

    /// Root mean square distance, metres.
    pub(super) fn rms_m(&self) -> f64 {
        self.variance_m2.iter().sum::<f64>().sqrt()
    }

    /// Probability that noise of this floor leaves a residual of as much variance (all axes together).
    pub(super) fn p_value(&self, variance_m2: f64, freedom: f64) -> f64 {
        let own: f64 = self.variance_m2.iter().sum();
        if self.freedom < 2.0 || own <= 0.0 {
            return 1.0;
        }
        f_above(variance_m2 / own, freedom, 3.0 * self.freedom)
    }

    /// This floor and a residual's variance of `freedom` degrees an axis, taken together.
    pub(super) fn pooled(&self, variance_m2: [f64; 3], freedom: f64) -> Floor {
        let all = self.freedom + freedom;
        let mean = |axis: usize| (self.freedom * self.variance_m2[axis] + freedom * variance_m2[axis]) / all;
        Floor {
            variance_m2: std::array::from_fn(mean),
            freedom: all,
            from: format!("{} and what the model leaves", self.from),
        }
    }
}

/// What a model leaves of things that were measured again and again, in the mean.
pub(super) struct Bias {
    /// Chance of as much where the model is right: the test for lack of fit against pure error (Draper & Smith, Applied
    /// Regression Analysis, section 2.1).
    pub(super) p_value: f64,
    /// Root mean square, metres.
    pub(super) rms_m: f64,
}

/// The bias of `left_m` (three numbers a sample) where commands were repeated or held. Starts are as independent as
/// trials, samples at rest as much as `noise` lets them be.
pub(super) fn bias(samples: &Samples, left_m: &[f64], noise: &Noise) -> Bias {
    let groups: Vec<Vec<usize>> = groups(samples).into_iter().filter(|group| group.len() > 1).collect();
    let (mut squares, mut weighed, mut weights) = (0.0, 0.0, 0.0);
    for group in &groups {
        let independent =
            if is_start(samples, group) { group.len() as f64 } else { noise.independent(group.len()).max(1.0) };
        let mean = |axis: usize| group.iter().map(|&row| left_m[3 * row + axis]).sum::<f64>() / group.len() as f64;
        let square: f64 = (0..3).map(|axis| mean(axis).powi(2)).sum();
        squares += independent * square;
        weighed += group.len() as f64 * square;
        weights += group.len() as f64;
    }
    let floor = Floor::of_repeats(samples);
    let own = floor.variance_m2.iter().sum::<f64>() / 3.0;
    let freedom = 3.0 * groups.len() as f64;
    let enough = floor.freedom >= 2.0 && own > 0.0;
    let p_value = if enough { f_above(squares / freedom / own, freedom, 3.0 * floor.freedom) } else { 1.0 };
    Bias { p_value, rms_m: (weighed / f64::max(weights, 1.0)).sqrt() }
}

/// Samples that measure the same thing again: the first rows of all trials under the same weight, then each rest.
fn groups(samples: &Samples) -> Vec<Vec<usize>> {
    let mut groups = starts(samples);
    groups.extend(rests(samples));
    groups
}

fn is_start(samples: &Samples, group: &[usize]) -> bool {
    group.first().is_some_and(|&row| samples.rows[row].row == 0)
}

/// The first rows of the trials, those under the same weight together.
fn starts(samples: &Samples) -> Vec<Vec<usize>> {
    let mut found: Vec<(f64, Vec<usize>)> = Vec::new();
    for row in (0..samples.len()).filter(|&row| samples.rows[row].row == 0) {
        let load_kg = samples.trials[samples.rows[row].trial].known_load_kg;
        match found.iter_mut().find(|(known_kg, _)| *known_kg == load_kg) {
            Some((_, rows)) => rows.push(row),
            None => found.push((load_kg, vec![row])),
        }
    }
    found.into_iter().map(|(_, rows)| rows).collect()
}

/// Runs of samples under one command that has been held long enough.
fn rests(samples: &Samples) -> Vec<Vec<usize>> {
    let mut found: Vec<Vec<usize>> = Vec::new();
    let mut held: Option<(usize, Vec<f64>, f64)> = None;
    let mut run: Vec<usize> = Vec::new();
    for (index, row) in samples.rows.iter().enumerate().filter(|(_, row)| row.row > 0) {
        let command = samples.trials[row.trial].commands.row(row.row - 1);
        let same = held.as_ref().is_some_and(|(trial, before, _)| *trial == row.trial && before.as_slice() == command);
        if !same {
            held = Some((row.trial, command.to_vec(), row.time_s));
            found.push(std::mem::take(&mut run));
        }
        if held.as_ref().is_some_and(|(_, _, since_s)| row.time_s - since_s >= SETTLED_S) {
            run.push(index);
        }
    }
    found.push(run);
    found.retain(|run| run.len() > 1);
    found
}

#[cfg(test)]
mod tests {
    use super::super::samples::white_noise;
    use super::*;

    const NOISE_M: f64 = 5e-4;

    /// What a model leaves in eight trials of ten samples that all begin in one place: noise, and at the start a bias.
    fn tested(bias_m: f64, seed: u64) -> Bias {
        let mut noise = white_noise(NOISE_M, seed);
        let mut samples = Samples::alike(8, 10);
        for sample in &mut samples.rows {
            let bias_m = if sample.row == 0 { bias_m } else { 0.0 };
            sample.tip_m = [bias_m + noise(), noise(), noise()];
        }
        let left_m: Vec<f64> = samples.rows.iter().flat_map(|sample| sample.tip_m).collect();
        bias(&samples, &left_m, &Noise { sigma_m: [NOISE_M; 3], correlation: 0.0 })
    }

    #[test]
    fn starts_under_another_weight_are_no_repeats() {
        let mut samples = Samples::alike(4, 1);
        for (k, (trial, sample)) in samples.trials.iter_mut().zip(&mut samples.rows).enumerate() {
            let weighed = k % 2 == 1;
            trial.known_load_kg = if weighed { 0.02 } else { 0.0 };
            sample.tip_m = [if weighed { 0.01 } else { 0.0 } + 1e-4 * (k / 2) as f64, 0.0, 0.2];
        }
        let floor = Floor::of_repeats(&samples);
        assert_eq!((floor.freedom, floor.from.as_str()), (2.0, "4 starts at home"));
        assert!((floor.variance_m2[0] - 0.5e-8).abs() < 1e-15, "{:?}", floor.variance_m2);
    }

    #[test]
    fn a_model_that_is_wrong_at_home_is_seen_and_noise_is_not() {
        let low = (0..200).filter(|&seed| tested(0.0, seed).p_value < 0.05).count();
        assert!((2..22).contains(&low), "{low} of 200 below 0.05");
        let found = tested(1e-3, 1);
        assert!(found.p_value < 1e-3, "{}", found.p_value);
        assert!((found.rms_m / 1e-3 - 1.0).abs() < 0.4, "{}", found.rms_m);
    }
}
