//! Choice of held-out trials: whole trials, chosen by their commands alone so that both parts
//! exercise every tendon. Measured values have no influence.

use super::samples::Samples;

/// With more possible choices than this, one choice is improved by exchanges instead of comparing
/// all.
const MAX_COMPARED_CHOICES: usize = 20_000;
/// Row shares above this bring no further benefit.
const MAX_ROW_SHARE: f64 = 0.75;
/// The held-out part may have fewer rows than the training part, by this factor.
const HELD_OUT_WEIGHT: f64 = 2.0;

/// Indices of training trials and of held-out trials.
pub(crate) fn split(samples: &Samples, share: f64) -> (Vec<usize>, Vec<usize>) {
    let trials = TrialStatistics::new(samples, share);
    let held_out = if count_choices(trials.count(), trials.held) <= MAX_COMPARED_CHOICES as f64 {
        trials.best_of_all()
    } else {
        trials.improved_by_exchange()
    };
    ((0..trials.count()).filter(|trial| !held_out.contains(trial)).collect(), held_out)
}

/// Number of ways to choose `held` of `count`.
fn count_choices(count: usize, held: usize) -> f64 {
    (0..held).map(|k| (count - k) as f64 / (k + 1) as f64).product()
}

/// Statistics of the trials that a choice depends on.
struct TrialStatistics {
    /// Sum of squared commands by trial and tendon.
    spreads: Vec<Vec<f64>>,
    /// Tracked rows by trial.
    rows: Vec<f64>,
    /// Means over all trials.
    usual: Vec<f64>,
    usual_rows: f64,
    /// Number of held-out trials.
    held: usize,
}

/// Quality of a choice: first the share of rows in both parts, then the share of tendon use.
#[derive(Clone, Copy, PartialEq)]
struct SplitQuality {
    rows: f64,
    tendons: f64,
}

impl TrialStatistics {
    fn new(samples: &Samples, share: f64) -> TrialStatistics {
        let count = samples.trials.len();
        let spreads: Vec<Vec<f64>> = (0..count).map(|trial| spread(samples, trial)).collect();
        let rows: Vec<f64> = samples.ranges().iter().map(|range| range.len() as f64).collect();
        // At least one trial on either side.
        let held = ((count as f64 * share).ceil() as usize).clamp(1, count - 1);
        let mean =
            |tendon: usize| spreads.iter().map(|spread| spread[tendon]).sum::<f64>() / count as f64;
        let usual = (0..spreads[0].len()).map(mean).collect();
        TrialStatistics {
            usual,
            usual_rows: rows.iter().sum::<f64>() / count as f64,
            spreads,
            rows,
            held,
        }
    }

    fn count(&self) -> usize {
        self.spreads.len()
    }

    /// Best choice by comparison of all; of equal ones the last trials.
    fn best_of_all(&self) -> Vec<usize> {
        let mut choice: Vec<usize> = (self.count() - self.held..self.count()).collect();
        let mut best = (self.quality(&choice), choice.clone());
        while previous_choice(&mut choice, self.count()) {
            let quality = self.quality(&choice);
            if is_better(quality, best.0) {
                best = (quality, choice.clone());
            }
        }
        best.1
    }

    /// Evenly spaced trials, improved by exchanging single trials as long as that helps.
    fn improved_by_exchange(&self) -> Vec<usize> {
        let mut choice: Vec<usize> =
            (0..self.held).map(|k| (2 * k + 1) * self.count() / (2 * self.held)).collect();
        let mut quality = self.quality(&choice);
        loop {
            let quality_before = quality;
            for k in 0..self.held {
                // Backwards, so that of equal choices the last trials win, as in `best_of_all`.
                for other in (0..self.count()).rev() {
                    let replaced = choice[k];
                    if choice.contains(&other) {
                        continue;
                    }
                    choice[k] = other;
                    let there = self.quality(&choice);
                    if is_better(there, quality) {
                        quality = there;
                    } else {
                        choice[k] = replaced;
                    }
                }
            }
            if quality == quality_before {
                choice.sort_unstable();
                return choice;
            }
        }
    }

    fn quality(&self, held_out: &[usize]) -> SplitQuality {
        let rest = self.count() - self.held;
        // The smaller share of either part counts, so that neither lacks rows or tendons.
        // Share of both parts over the mean of all trials.
        let shares = |sum: f64, usual: f64| {
            let share = sum / (self.held as f64 * usual);
            [share, (self.count() as f64 - self.held as f64 * share) / rest as f64]
        };
        let sum = |of: &dyn Fn(usize) -> f64| held_out.iter().map(|&trial| of(trial)).sum::<f64>();
        let [proved, fitted] = shares(sum(&|trial| self.rows[trial]), self.usual_rows);
        let used = (0..self.usual.len()).filter(|&tendon| self.usual[tendon] > 0.0);
        let exercise = used.flat_map(|tendon| {
            shares(sum(&|trial| self.spreads[trial][tendon]), self.usual[tendon])
        });
        SplitQuality {
            // Beyond three quarters more rows are worth less than even use of the tendons.
            rows: fitted.min(HELD_OUT_WEIGHT * proved).min(MAX_ROW_SHARE),
            tendons: exercise.fold(1.0, f64::min),
        }
    }
}

fn is_better(there: SplitQuality, here: SplitQuality) -> bool {
    const TOLERANCE: f64 = 1e-9;
    let has_as_many_rows = there.rows > here.rows - TOLERANCE;
    // Without the tolerance rounding could make two equal choices replace each other for ever.
    there.rows > here.rows + TOLERANCE
        || has_as_many_rows && there.tendons > here.tendons + TOLERANCE
}

/// Sum of squared commands of each tendon in a trial.
fn spread(samples: &Samples, trial: usize) -> Vec<f64> {
    let commands = &samples.trials[trial].commands;
    let mut sums = vec![0.0; commands.width()];
    for row in commands.iter() {
        // A slack tendon, with a negative command, exercises nothing.
        sums.iter_mut().zip(row).for_each(|(sum, command)| *sum += command.max(0.0).powi(2));
    }
    sums
}

/// Steps to the previous choice in lexicographic order; false at the first.
fn previous_choice(choice: &mut [usize], count: usize) -> bool {
    let held = choice.len();
    // Lower the last element that can be lowered; set those after it as high as possible.
    for k in (0..held).rev() {
        let low = if k == 0 { 0 } else { choice[k - 1] + 1 };
        if choice[k] > low {
            choice[k] -= 1;
            for (offset, after) in (k + 1..held).enumerate() {
                choice[after] = count - (held - k - 1) + offset;
            }
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rows;
    use crate::discovery::recording::samples::Sample;

    #[test]
    fn every_choice_is_met_once() {
        let mut choice = vec![3, 4];
        let mut met = vec![choice.clone()];
        while previous_choice(&mut choice, 5) {
            met.push(choice.clone());
        }
        met.sort();
        met.dedup();
        assert_eq!(met.len(), 10);
        assert_eq!(met[0], [0, 1]);
    }

    /// Trials of these row counts, each of which pulls two of four tendons.
    fn pulled(trials: &[(usize, [usize; 2])]) -> Samples {
        let mut samples = Samples::alike(trials.len(), 1);
        samples.rows.clear();
        for (trial, &(rows, tendons)) in trials.iter().enumerate() {
            let mut commands = Rows::new(4);
            let row: [f64; 4] =
                std::array::from_fn(|tendon| if tendons.contains(&tendon) { 0.01 } else { 0.0 });
            (1..rows).for_each(|_| commands.push(&row));
            samples.trials[trial].durations_s = vec![0.2; rows - 1];
            samples.trials[trial].commands = commands;
            let sample = |row: usize| Sample::of_tip(trial, row, 0.2 * row as f64);
            samples.rows.extend((0..rows).map(sample));
        }
        samples
    }

    #[test]
    fn the_longest_trial_is_fitted_to() {
        let (fit, held_out) = split(&pulled(&[(400, [0, 2]), (30, [0, 1]), (30, [2, 3])]), 0.25);
        assert_eq!((fit.len(), held_out.len()), (2, 1));
        assert!(fit.contains(&0), "{fit:?}");
    }

    #[test]
    fn of_many_trials_those_are_held_out_that_use_every_tendon() {
        let trials: Vec<(usize, [usize; 2])> =
            (0..40).map(|k| (20, if k < 20 { [0, 2] } else { [1, 3] })).collect();
        let (fit, held_out) = split(&pulled(&trials), 0.25);
        assert_eq!((fit.len(), held_out.len()), (30, 10));
        for part in [fit, held_out] {
            let early = part.iter().filter(|&&trial| trial < 20).count();
            assert_eq!(2 * early, part.len(), "{part:?}");
        }
    }
}
