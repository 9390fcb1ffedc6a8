//! Fit a set with each promising effect added: all roughly, the leading ones fully.

use super::screening::{HOPELESS, LinearPrediction};
use super::state::{ScoredSet, Search};
use crate::discovery::fit::candidate::CandidateEffect;
/// Maximum number of rough fits, and of full fits among them.
pub(crate) const WIDTH: usize = 8;
/// Trust in the linear prediction: relative to the best one, and absolute.
const PROMISE_SHARE: f64 = 0.7;
const PROMISE_SLACK: f64 = 30.0;
/// Deficit of a rough fit: relative (sizes alone; with shapes or choices) and absolute.
const SHORT_SHARE: f64 = 0.1;
const SHAPELESS_SHARE: f64 = 0.25;
const SHORT: f64 = 10.0;
impl Search<'_> {
    /// Fits `base` with each promising candidate: all roughly, then fully those that may come near the best and near
    /// the score `enough`.
    pub(crate) fn fit_additions(
        &mut self,
        base: &ScoredSet,
        predictions: &[LinearPrediction],
        enough: f64,
    ) -> Vec<ScoredSet> {
        let Some(first) = predictions.first() else { return Vec::new() };
        let (least, width) = if self.is_exhaustive(base) {
            (f64::NEG_INFINITY, usize::MAX)
        } else {
            (first.gain - (PROMISE_SHARE * first.gain).max(PROMISE_SLACK), WIDTH)
        };
        let kept: Vec<&LinearPrediction> =
            predictions.iter().take(width).filter(|prediction| prediction.gain >= least).collect();
        let mut rough = self.fit_problem.rough_additions(base, &kept, &self.sensitivities, enough);
        rough.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut top = rough.iter().map(|scored| scored.score).fold(base.score.max(enough), f64::max);
        let mut finished: Vec<ScoredSet> = Vec::new();
        for scored in rough {
            if finished.len() == WIDTH || !self.is_promising(&scored, base, top) {
                self.tried.push(scored);
                continue;
            }
            // Keep the rough fit if the full fit fails.
            let scored = self.fit_fully(&scored);
            top = top.max(scored.score);
            finished.push(scored);
        }
        self.tried.extend(finished.iter().cloned());
        finished
    }

    /// Whether a rough fit with one member added may reach the score `top` after a full fit.
    fn is_promising(&self, rough: &ScoredSet, base: &ScoredSet, top: f64) -> bool {
        let adds = rough.score - base.score;
        let added = rough.fitted.members.last().map(|member| &self.fit_problem.candidates[member.candidate]);
        let share = if added.is_some_and(CandidateEffect::has_shape) { SHAPELESS_SHARE } else { SHORT_SHARE };
        let hopeless = adds < HOPELESS - self.limits.rival_score;
        !hopeless && rough.score + share * adds.max(0.0) + SHORT >= top - self.limits.rival_score
    }
}
