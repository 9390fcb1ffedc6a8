//! The noise floor from the data themselves: every trial starts at rest at home, so its first rows are repeats of one
//! measurement; commands that are held show the tip at rest; and noise changes from one sample to the next, which what a
//! model lacks hardly does.

pub(crate) mod dwell_ar1;
pub(crate) mod nugget;
pub(crate) mod trial_starts;

use super::fit::ar1_noise::{Noise, alike};
use super::fit::nuisance::Explained;
use super::recording::samples::{Samples, TrialCommands};
use crate::math::distribution::f_above;
use nugget::nugget;

/// An estimate of noise.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Floor {
    /// Variance along x, y and z, m².
    pub(crate) variance_m2: [f64; 3],
    /// Degrees of freedom behind each of them.
    pub(crate) freedom: f64,
    /// What it was estimated from, in words.
    pub(crate) from: Vec<String>,
}

/// A command is at rest once it has been held for so long, seconds.
const SETTLED_S: f64 = 1.0;
/// Chance below which repeats and neighbours contradict each other. Neighbours are many, and may all hold what changes faster
/// than they follow each other; few repeats scatter by little or much once in a thousand recordings.
const CONTRADICTS: f64 = 1e-5;

impl Floor {
    /// From all that the `samples` tell of noise beside a model that has the tip at `played`: repeats, rests, and neighbours,
    /// where what `explained` leaves has no memory and repeats do not contradict it.
    pub(crate) fn of(samples: &Samples, explained: &Explained, played: &[f64]) -> Floor {
        let repeats = Floor::of_repeats(samples, explained.noise.correlation);
        let neighbours = Floor::of_neighbours(samples, explained, played);
        match neighbours.filter(|neighbours| !repeats.contradicts(neighbours)) {
            Some(neighbours) => repeats.and(neighbours),
            None => repeats,
        }
    }

    /// From what changes from one sample to the next.
    fn of_neighbours(samples: &Samples, explained: &Explained, played: &[f64]) -> Option<Floor> {
        let nugget = nugget(samples, explained, played)?;
        let from = vec!["what changes from one sample to the next".to_owned()];
        Some(Floor { variance_m2: nugget.variance_m2, freedom: nugget.freedom, from })
    }

    /// What a fit leaves, as if all of it were noise.
    pub(crate) fn left_by(explained: &Explained, samples: &Samples) -> Floor {
        Floor {
            variance_m2: explained.noise.sigma_m.map(|sigma| sigma * sigma),
            freedom: explained.noise.independent(samples.len()),
            from: vec!["what the model leaves".to_owned()],
        }
    }

    /// From repeats of the first row and from rests; no degrees of freedom where there are neither. `correlation`: that of
    /// what is taken for noise, which stands unless rests contradict it.
    pub(crate) fn of_repeats(samples: &Samples, correlation: f64) -> Floor {
        Floor::of_groups(samples, &groups(samples), correlation)
    }

    /// From the first rows of trials alone.
    pub(crate) fn of_starts(samples: &Samples) -> Floor {
        Floor::of_groups(samples, &starts(samples), 0.0)
    }

    /// From groups of samples, each of one thing.
    fn of_groups(samples: &Samples, groups: &[Vec<usize>], correlation: f64) -> Floor {
        let at_rest: Vec<&[usize]> = groups.iter().filter(|g| !is_start(samples, g)).map(Vec::as_slice).collect();
        let correlation = dwell_ar1::correlation(samples, &at_rest, correlation);
        let repeats = dwell_ar1::Worth::of(groups.iter().filter(|g| is_start(samples, g)).map(Vec::len), 0.0);
        let worth = repeats.and(dwell_ar1::Worth::of(at_rest.iter().map(|rest| rest.len()), correlation));
        let squares_m2: Vec<[f64; 3]> = groups.iter().map(|group| dwell_ar1::squares_m2(samples, group)).collect();
        let variance =
            |axis: usize| squares_m2.iter().map(|own| own[axis]).sum::<f64>() / worth.mean.max(f64::MIN_POSITIVE);
        let variance_m2 = std::array::from_fn(variance);
        let freedom = worth.freedom();
        let (starts, rests): (Vec<&Vec<usize>>, Vec<&Vec<usize>>) =
            groups.iter().partition(|group| is_start(samples, group));
        let [firsts, rests] = [starts, rests].map(|groups| groups.iter().map(|group| group.len()).sum::<usize>());
        let mut from = Vec::new();
        from.extend((firsts > 1).then(|| format!("{firsts} starts at home")));
        from.extend((rests > 1).then(|| format!("{rests} samples at rest")));
        Floor { variance_m2, freedom, from }
    }

    /// Root mean square distance, metres.
    pub(crate) fn rms_m(&self) -> f64 {
        self.variance_m2.iter().sum::<f64>().sqrt()
    }

    /// Probability that noise of this floor leaves a residual of as much variance (all axes together).
    fn p_value(&self, variance_m2: f64, freedom: f64) -> f64 {
        let own: f64 = self.variance_m2.iter().sum();
        if self.freedom < 2.0 || own <= 0.0 {
            return 1.0;
        }
        f_above(variance_m2 / own, freedom, alike(&self.variance_m2) * self.freedom)
    }

    /// Probability that noise of this floor shows itself as `other`, or as more.
    pub(crate) fn chance_of(&self, other: &Floor) -> f64 {
        self.p_value(other.variance_m2.iter().sum(), alike(&other.variance_m2) * other.freedom)
    }

    /// Whether `other` is more, beyond any chance.
    pub(crate) fn is_exceeded_by(&self, other: &Floor) -> bool {
        self.chance_of(other) < CONTRADICTS
    }

    fn contradicts(&self, other: &Floor) -> bool {
        self.freedom > 0.0 && (self.is_exceeded_by(other) || other.is_exceeded_by(self))
    }

    /// This floor and another one, taken together.
    pub(crate) fn and(self, other: Floor) -> Floor {
        if self.freedom <= 0.0 {
            return other;
        }
        let all = self.freedom + other.freedom;
        let mean =
            |axis: usize| (self.freedom * self.variance_m2[axis] + other.freedom * other.variance_m2[axis]) / all;
        let from = [self.from, other.from].concat();
        Floor { variance_m2: std::array::from_fn(mean), freedom: all, from }
    }
}

/// What a model leaves of things that were measured again and again, in the mean.
pub(crate) struct Bias {
    /// Chance of as much where the model is right: the test for lack of fit against pure error (Draper & Smith, Applied
    /// Regression Analysis, section 2.1).
    pub(crate) p_value: f64,
    /// Root mean square, metres.
    pub(crate) rms_m: f64,
}

/// The bias of `left_m` (three numbers a sample) where commands were repeated or held, beside the noise `floor`. Starts are as
/// independent as trials, samples at rest as much as `noise` lets them be.
pub(crate) fn bias(samples: &Samples, left_m: &[f64], noise: &Noise, floor: &Floor) -> Bias {
    let groups = groups(samples);
    if groups.is_empty() {
        return Bias { p_value: 1.0, rms_m: 0.0 };
    }
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
    let p_value = floor.p_value(squares / groups.len() as f64, alike(&floor.variance_m2) * groups.len() as f64);
    Bias { p_value, rms_m: (weighed / weights).sqrt() }
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

/// The first rows of the trials, those under the same weight together, where there are several.
fn starts(samples: &Samples) -> Vec<Vec<usize>> {
    let mut found: Vec<(f64, Vec<usize>)> = Vec::new();
    for row in (0..samples.len()).filter(|&row| samples.rows[row].row == 0) {
        let load_kg = samples.trials[samples.rows[row].trial].known_load_kg;
        match found.iter_mut().find(|(known_kg, _)| *known_kg == load_kg) {
            Some((_, rows)) => rows.push(row),
            None => found.push((load_kg, vec![row])),
        }
    }
    found.into_iter().map(|(_, rows)| rows).filter(|rows| rows.len() > 1).collect()
}

/// Runs of samples under one command and load that have been there long enough.
fn rests(samples: &Samples) -> Vec<Vec<usize>> {
    let begun: Vec<Vec<usize>> = samples.trials.iter().map(begun).collect();
    let mut found: Vec<Vec<usize>> = Vec::new();
    let mut held: Option<(usize, usize, f64)> = None;
    let mut run: Vec<usize> = Vec::new();
    for (index, row) in samples.rows.iter().enumerate().filter(|(_, row)| row.row > 0) {
        let since = begun[row.trial][row.row - 1];
        if held.is_none_or(|(trial, before, _)| (trial, before) != (row.trial, since)) {
            held = Some((row.trial, since, row.time_s));
            found.push(std::mem::take(&mut run));
        }
        if held.is_some_and(|(_, _, since_s)| row.time_s - since_s >= SETTLED_S) {
            run.push(index);
        }
    }
    found.push(run);
    found.retain(|run| run.len() > 1);
    found
}

/// For each command of a trial, the first of those before it that were the same, load and all.
fn begun(trial: &TrialCommands) -> Vec<usize> {
    let load = |k: usize| trial.tip_loads.as_ref().map(|loads| loads[k]);
    let mut begun: Vec<usize> = Vec::with_capacity(trial.commands.len());
    for k in 0..trial.commands.len() {
        let goes_on = k > 0 && trial.commands.row(k) == trial.commands.row(k - 1) && load(k) == load(k - 1);
        begun.push(if goes_on { begun[k - 1] } else { k });
    }
    begun
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::base::Rows;
    use crate::discovery::recording::samples::white_noise;
    use crate::rod::TipLoad;

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
        let floor = Floor::of_repeats(&samples, 0.0);
        bias(&samples, &left_m, &Noise { sigma_m: [NOISE_M; 3], correlation: 0.0 }, &floor)
    }

    #[test]
    fn starts_under_another_weight_are_no_repeats() {
        let mut samples = Samples::alike(4, 1);
        for (k, (trial, sample)) in samples.trials.iter_mut().zip(&mut samples.rows).enumerate() {
            let weighed = k % 2 == 1;
            trial.known_load_kg = if weighed { 0.02 } else { 0.0 };
            sample.tip_m = [if weighed { 0.01 } else { 0.0 } + 1e-4 * (k / 2) as f64, 0.0, 0.2];
        }
        let floor = Floor::of_repeats(&samples, 0.0);
        assert_eq!((floor.freedom, floor.from), (2.0, vec!["4 starts at home".to_owned()]));
        assert!((floor.variance_m2[0] - 0.5e-8).abs() < 1e-15, "{:?}", floor.variance_m2);
    }

    /// Few repeats scatter by little now and then, and neighbours know better; not where that is no chance.
    #[test]
    fn neighbours_help_where_repeats_do_not_contradict_them() {
        for (starts, all) in [(1.0, 1.0), (0.4, 1.0), (0.05, 0.05)] {
            let mut samples = Samples::alike(6, 50);
            let left_m = samples.noise(NOISE_M, 0.0, 1);
            let mut place = white_noise(0.01, 2);
            let played: Vec<f64> = left_m.iter().map(|_| place()).collect();
            for (row, sample) in samples.rows.iter_mut().enumerate() {
                let times = if sample.row == 0 { starts } else { 1.0 };
                sample.tip_m = std::array::from_fn(|axis| times * left_m[3 * row + axis]);
            }
            let noise = Noise::of(&samples, &left_m, 0.0);
            let explained = Explained { noise, amounts: DVector::zeros(0), left_m, deviance: 0.0 };
            let floor = Floor::of(&samples, &explained, &played);
            let ratio = floor.rms_m() / (3.0_f64.sqrt() * NOISE_M);
            assert!((ratio / all - 1.0).abs() < 0.25, "{starts}: {ratio}, {:?}", floor.from);
        }
    }

    #[test]
    fn a_model_that_is_wrong_at_home_is_seen_and_noise_is_not() {
        let low = (0..200).filter(|&seed| tested(0.0, seed).p_value < 0.05).count();
        assert!((2..22).contains(&low), "{low} of 200 below 0.05");
        let found = tested(1e-3, 1);
        assert!(found.p_value < 1e-3, "{}", found.p_value);
        assert!((found.rms_m / 1e-3 - 1.0).abs() < 0.4, "{}", found.rms_m);
    }

    /// Six trials that stay where they are, under noise that remembers.
    #[test]
    fn rests_in_noise_that_remembers_say_how_large_it_is() {
        for correlation in [0.0_f64, 0.5, 0.8, 0.9] {
            let (mut ratios, mut low) = (Vec::new(), 0);
            for seed in 0..200 {
                let mut samples = Samples::alike(6, 50);
                for trial in &mut samples.trials {
                    // Four poses, each held for two seconds and a half.
                    trial.commands = Rows::new(1);
                    (1..50).for_each(|k| trial.commands.push(&[f64::from(k / 13)]));
                }
                let left_m = samples.noise(NOISE_M, correlation, seed);
                for (sample, left_m) in samples.rows.iter_mut().zip(left_m.as_chunks().0) {
                    sample.tip_m = *left_m;
                }
                let floor = Floor::of_repeats(&samples, correlation);
                ratios.push((floor.rms_m() / NOISE_M).powi(2) / 3.0);
                let all_m2 = samples.rows.iter().flat_map(|row| row.tip_m).map(|x| x * x).sum::<f64>() / 300.0;
                let known = Noise { sigma_m: [NOISE_M; 3], correlation };
                low += usize::from(floor.p_value(all_m2, 3.0 * known.independent(300)) < 0.05);
            }
            let mean = crate::math::summary::mean(&ratios);
            assert!((mean - 1.0).abs() < 0.05, "{correlation}: {mean}");
            assert!(low < 20, "{correlation}: {low} of 200 below 0.05");
        }
    }

    #[test]
    fn a_load_that_changes_ends_a_rest_as_a_command_does_that_nobody_saw() {
        let mut samples = Samples::alike(1, 30);
        samples.trials[0].commands = Rows::new(1);
        (1..30).for_each(|_| samples.trials[0].commands.push(&[1.0]));
        assert_eq!(rests(&samples).iter().map(Vec::len).collect::<Vec<_>>(), [24]);
        let loads =
            |k: usize| TipLoad { force_n: [f64::from(u8::from(k >= 15)), 0.0, 0.0].into(), ..TipLoad::default() };
        let mut loaded = samples.clone();
        loaded.trials[0].tip_loads = Some((0..29).map(loads).collect());
        assert_eq!(rests(&loaded).iter().map(Vec::len).collect::<Vec<_>>(), [10, 9]);
        // Away and back again while the tracker saw nothing.
        let mut away = samples;
        away.trials[0].commands = Rows::new(1);
        (1..30).for_each(|k| away.trials[0].commands.push(&[if k == 15 { 2.0 } else { 1.0 }]));
        away.rows.retain(|row| !(14..17).contains(&row.row));
        assert_eq!(rests(&away).iter().map(Vec::len).collect::<Vec<_>>(), [8, 8]);
    }
}
