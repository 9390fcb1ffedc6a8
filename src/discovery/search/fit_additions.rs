//! Fit a set with each promising effect added: all roughly, the leading ones fully.

use super::screening::{LinearPrediction, MIN_PREDICTED_SCORE};
use super::state::{ScoredSet, Search};
use crate::discovery::fit::candidate::CandidateEffect;

/// Maximum number of rough fits, and of full fits among them.
pub(crate) const MAX_FITS: usize = 8;
/// Trust in the linear prediction: relative to the best one, and absolute.
const GAIN_TOLERANCE_SHARE: f64 = 0.7;
const GAIN_TOLERANCE: f64 = 30.0;
/// Deficit of a rough fit: relative (sizes alone; with shapes or choices) and absolute.
const DEFICIT_SHARE: f64 = 0.1;
const DEFICIT_SHARE_WITH_SHAPE: f64 = 0.25;
const DEFICIT: f64 = 10.0;

impl Search<'_> {
    /// Fits `base` with each promising candidate: all roughly, then fully those that may come near
    /// the best and near the score `min_score`.
    pub(crate) fn fit_additions(
        &mut self,
        base: &ScoredSet,
        predictions: &[LinearPrediction],
        min_score: f64,
    ) -> Vec<ScoredSet> {
        let Some(first) = predictions.first() else { return Vec::new() };
        let (min_gain, max_fits) = if self.is_exhaustive(base) {
            (f64::NEG_INFINITY, usize::MAX)
        } else {
            (first.gain - (GAIN_TOLERANCE_SHARE * first.gain).max(GAIN_TOLERANCE), MAX_FITS)
        };
        // The linear prediction is trusted to order candidates, not to tell their gain.
        let promising: Vec<&LinearPrediction> = predictions
            .iter()
            .take(max_fits)
            .filter(|prediction| prediction.gain >= min_gain)
            .collect();
        let mut rough =
            self.fit_problem.rough_additions(base, &promising, &self.sensitivities, min_score);
        rough.sort_by(|a, b| b.score.total_cmp(&a.score));
        // Best first, so that hopeless fits meet the highest bar.
        let mut best_score =
            rough.iter().map(|scored| scored.score).fold(base.score.max(min_score), f64::max);
        let mut finished: Vec<ScoredSet> = Vec::new();
        // What full fits have brought over rough ones: as much may be missing from the others.
        let mut brought = 0.0_f64;
        for scored in rough {
            if finished.len() == MAX_FITS || !self.is_promising(&scored, base, best_score - brought)
            {
                self.tried.push(scored);
                continue;
            }
            // Keep the rough fit if the full fit fails.
            let rough_score = scored.score;
            let scored = self.fit_fully(&scored);
            brought = brought.max(scored.score - rough_score);
            best_score = best_score.max(scored.score);
            finished.push(scored);
        }
        self.tried.extend(finished.iter().cloned());
        finished
    }

    /// Whether a rough fit with one member added may reach the score `best_score` after a full fit.
    fn is_promising(&self, rough: &ScoredSet, base: &ScoredSet, best_score: f64) -> bool {
        let adds = rough.score - base.score;
        let added = rough
            .fitted
            .members
            .last()
            .map(|member| &self.fit_problem.candidates[member.candidate]);
        let share = if added.is_some_and(CandidateEffect::has_shape) {
            DEFICIT_SHARE_WITH_SHAPE
        } else {
            DEFICIT_SHARE
        };
        // A rival needs to come this near only, even if it is never named.
        let is_hopeless = adds < MIN_PREDICTED_SCORE - self.limits.rival_score;
        !is_hopeless
            && rough.score + share * adds.max(0.0) + DEFICIT >= best_score - self.limits.rival_score
    }
}
