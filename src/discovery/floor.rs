//! The noise floor from the data themselves: every trial starts at rest at home, so its first rows are repeats of one
//! measurement; commands that are held show the tip at rest.

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
        let firsts: Vec<usize> = (0..samples.len()).filter(|&row| samples.rows[row].row == 0).collect();
        let mut groups = vec![firsts];
        groups.extend(rests(samples));
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
        let rests = groups[1..].iter().map(Vec::len).sum::<usize>();
        let firsts = groups[0].len();
        let from = match (firsts > 1, rests > 1) {
            (true, true) => format!("{firsts} starts at home and {rests} samples at rest"),
            (true, false) => format!("{firsts} starts at home"),
            (false, true) => format!("{rests} samples at rest"),
            (false, false) => "the residual alone: nothing was measured twice".to_owned(),
        };
        Floor { variance_m2, freedom, from }
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
