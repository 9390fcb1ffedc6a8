//! Which trials are kept back as proof: whole trials, chosen by their commands alone, so that the proof and the rest both
//! exercise every tendon. What was measured has no say.

use super::samples::Samples;

/// More ways to choose than this are not all compared: these are, from the last trials backwards.
const MOST_CHOICES: usize = 20_000;

/// The trials of the fit and those of the proof, by their index.
pub(super) fn split(samples: &Samples, share: f64) -> (Vec<usize>, Vec<usize>) {
    let count = samples.trials.len();
    let held = ((count as f64 * share).ceil() as usize).clamp(1, count - 1);
    let spreads: Vec<Vec<f64>> = (0..count).map(|trial| spread(samples, trial)).collect();
    let whole = cover(&spreads, &(0..count).collect::<Vec<_>>());
    let mut choice: Vec<usize> = (count - held..count).collect();
    let mut best = (worth(&spreads, &choice, &whole), choice.clone());
    // Every other choice, from the last one backwards, so that among equals the last trials are kept.
    for _ in 0..MOST_CHOICES {
        if !previous(&mut choice, count) {
            break;
        }
        let value = worth(&spreads, &choice, &whole);
        if value > best.0 + 1e-9 {
            best = (value, choice.clone());
        }
    }
    let fit = (0..count).filter(|trial| !best.1.contains(trial)).collect();
    (fit, best.1)
}

/// Sum of squares of each tendon's commands in a trial.
fn spread(samples: &Samples, trial: usize) -> Vec<f64> {
    let commands = &samples.trials[trial].commands;
    let mut sums = vec![0.0; commands.width()];
    for row in commands.iter() {
        sums.iter_mut().zip(row).for_each(|(sum, command)| *sum += command.max(0.0).powi(2));
    }
    sums
}

/// Mean over trials.
fn cover(spreads: &[Vec<f64>], trials: &[usize]) -> Vec<f64> {
    let mean = |tendon: usize| trials.iter().map(|&trial| spreads[trial][tendon]).sum::<f64>() / trials.len() as f64;
    (0..spreads[0].len()).map(mean).collect()
}

/// How much of its usual exercise the least exercised tendon gets, in the proof or in the rest.
fn worth(spreads: &[Vec<f64>], proof: &[usize], whole: &[f64]) -> f64 {
    let rest: Vec<usize> = (0..spreads.len()).filter(|trial| !proof.contains(trial)).collect();
    let least = |trials: &[usize]| {
        let share =
            cover(spreads, trials).into_iter().zip(whole).filter(|(_, all)| **all > 0.0).map(|(own, all)| own / all);
        share.fold(1.0, f64::min)
    };
    least(proof).min(least(&rest))
}

/// The choice before this one in lexicographic order; false when it was the first.
fn previous(choice: &mut [usize], count: usize) -> bool {
    let held = choice.len();
    // The last element that can go down, with those after it as high as can be.
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

    #[test]
    fn every_choice_is_met_once() {
        let mut choice = vec![3, 4];
        let mut met = vec![choice.clone()];
        while previous(&mut choice, 5) {
            met.push(choice.clone());
        }
        met.sort();
        met.dedup();
        assert_eq!(met.len(), 10);
        assert_eq!(met[0], [0, 1]);
    }
}
