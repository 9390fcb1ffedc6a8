//! How much of the gap an answer explains: the share of the held-out squares, beyond what the model
//! leaves on this robot anyway, that the effects remove.

use std::ops::Range;

use rand::RngExt;

use crate::discovery::fit::candidate::effect_specs;
use crate::discovery::fit::gauss_newton::{FitProblem, FittedSet};
use crate::discovery::fit::simulate;
use crate::discovery::problem::Problem;
use crate::math::summary::mean;

/// Share of the gap that effects explain, and what they leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ExplainedShare {
    /// One minus the squares left over those before, each beyond the yardstick; at most 1, and 0
    /// without a gap.
    pub(crate) share: f64,
    /// Its 95 % interval.
    pub(crate) interval_95: [f64; 2],
    /// Rms tip error beyond the yardstick, metres.
    pub(crate) left_m: f64,
}

/// Samples of a block that is drawn together: residuals of neighbours are correlated.
const BLOCK_SAMPLES: usize = 10;
/// Draws of the bootstrap.
const DRAWS: usize = 1000;

impl Problem<'_> {
    /// Share of the held-out gap that the `answer` explains; none if it cannot be simulated there.
    ///
    /// Uncertain parameters and errors shared with the baseline are taken off: before by their
    /// prior (that is, by the baseline), after by the fit of the answer. The yardstick is what is
    /// left of trials of the baseline that their correction has not seen; without a baseline it is
    /// `floor_m` (noise) with the model-form error of the options. The interval is from a block
    /// bootstrap over held-out samples and those of the baseline (Künsch, Annals of Statistics 17,
    /// 1989).
    pub(crate) fn explained_share(
        &self,
        fit_problem: &FitProblem,
        answer: &FittedSet,
        floor_m: f64,
    ) -> Option<ExplainedShare> {
        let added = effect_specs(&self.candidates, &answer.members)?;
        let simulated_m = simulate::tips(&self.model, &added, &self.held_out)?;
        let nuisances = self.nuisances_with(&[], &self.held_out, &self.held_out_simulated_m);
        // Before the answer nothing was fitted to this recording: the prior alone corrects it.
        let before = squares_m2(
            &nuisances.residual_by_prior(&self.held_out.residual(&self.held_out_simulated_m)),
        );
        let after =
            squares_m2(&self.explain_held_out(fit_problem, answer, &simulated_m)?.residual_m);
        // Trials of the baseline that their own correction has not seen are as unseen as held-out
        // ones.
        let yardstick = match &self.base {
            Some(base) => squares_m2(&base.form.unseen_m),
            None => vec![floor_m.powi(2) + self.model_form_m.powi(2)],
        };
        Some(explained(&before, &after, &yardstick, self.options.seed().child("explained").rng()))
    }
}

/// Squared length of the residual of each sample.
fn squares_m2(residual_m: &[f64]) -> Vec<f64> {
    residual_m.chunks_exact(3).map(|sample| sample.iter().map(|x| x * x).sum()).collect()
}

/// The share from squares a sample: `before` and `after` of the same samples, and those of the
/// yardstick.
fn explained(
    before: &[f64],
    after: &[f64],
    yardstick: &[f64],
    mut random: impl RngExt,
) -> ExplainedShare {
    let left_m2 = (mean(after) - mean(yardstick)).max(0.0);
    let mut drawn: Vec<f64> = (0..DRAWS)
        .map(|_| {
            // The same rows before and after: both errors of a sample belong together.
            let rows = blocks_drawn(before.len(), &mut random);
            let reference = blocks_drawn(yardstick.len(), &mut random);
            let mean_of = |squares: &[f64], rows: &[usize]| {
                mean(&rows.iter().map(|&row| squares[row]).collect::<Vec<f64>>())
            };
            share(mean_of(before, &rows), mean_of(after, &rows), mean_of(yardstick, &reference))
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    let at = |chance: f64| drawn[((DRAWS - 1) as f64 * chance).round() as usize];
    ExplainedShare {
        share: share(mean(before), mean(after), mean(yardstick)),
        interval_95: [at(0.025), at(0.975)],
        left_m: left_m2.sqrt(),
    }
}

fn share(before_m2: f64, after_m2: f64, yardstick_m2: f64) -> f64 {
    let gap_m2 = before_m2 - yardstick_m2;
    // A worse model explains a negative share; below -1 the number tells nothing more.
    if gap_m2 > 0.0 {
        (1.0 - (after_m2 - yardstick_m2).max(0.0) / gap_m2).clamp(-1.0, 1.0)
    } else {
        0.0
    }
}

/// Rows of as many blocks as `count` rows have, drawn with replacement.
fn blocks_drawn(count: usize, random: &mut impl RngExt) -> Vec<usize> {
    let blocks: Vec<Range<usize>> = (0..count)
        .step_by(BLOCK_SAMPLES)
        .map(|from| from..(from + BLOCK_SAMPLES).min(count))
        .collect();
    (0..blocks.len()).flat_map(|_| blocks[random.random_range(0..blocks.len())].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    #[test]
    fn the_share_is_of_what_exceeds_the_yardstick() {
        let of = |after: f64| explained(&[10.0; 40], &[after; 40], &[2.0; 40], Seed(1).rng());
        assert_eq!(
            of(4.0),
            ExplainedShare { share: 0.75, interval_95: [0.75, 0.75], left_m: 2.0_f64.sqrt() }
        );
        // As good as the robot as built: all of it, and no more than all of it.
        assert_eq!((of(2.0).share, of(1.0).share, of(1.0).left_m), (1.0, 1.0, 0.0));
        assert!(of(12.0).share < 0.0, "worse than before");
        assert_eq!(
            explained(&[1.0; 40], &[0.5; 40], &[2.0; 40], Seed(1).rng()).share,
            0.0,
            "there is no gap"
        );
    }

    #[test]
    fn few_samples_leave_a_wide_interval() {
        let wave: Vec<f64> = (0..60).map(|k| 1.0 + f64::from(k / 10 % 2)).collect();
        let before: Vec<f64> = wave.iter().map(|square| 5.0 * square).collect();
        let explained = explained(&before, &wave, &[0.5; 60], Seed(2).rng());
        let [low, high] = explained.interval_95;
        assert!(
            low < explained.share && explained.share < high && high - low > 0.02,
            "{explained:?}"
        );
    }
}
