//! Fit a set with each promising effect added: all roughly, the leading ones fully.

use super::screening::{HOPELESS, LinearPrediction};
use super::state::{ScoredSet, Search};
use crate::discovery::fit::candidate::CandidateEffect;
/// Rough fits at most, and of them those that are fitted further.
pub(crate) const WIDTH: usize = 8;
/// Promises are taken to be right to this share of the best, or to so much.
const PROMISE_SHARE: f64 = 0.7;
const PROMISE_SLACK: f64 = 30.0;
/// A rough fit may be short by this share of what it adds, where it is of sizes alone and where a shape or a place is
/// yet to be found, and by so much.
const SHORT_SHARE: f64 = 0.1;
const SHAPELESS_SHARE: f64 = 0.25;
const SHORT: f64 = 10.0;
impl Search<'_> {
    /// Fits `base` with each of the promising candidates besides: all roughly, then as well as can be those that may come
    /// near the best of them and near the score `enough`.
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
            // What cannot be fitted further stays as roughly as it is, so that nothing that predictions much is lost.
            let scored = self.fit_fully(&scored);
            top = top.max(scored.score);
            finished.push(scored);
        }
        self.tried.extend(finished.iter().cloned());
        finished
    }

    /// Whether a rough fit of `base` with one member more may come near the score `top` once it is fitted further.
    fn is_promising(&self, rough: &ScoredSet, base: &ScoredSet, top: f64) -> bool {
        let adds = rough.score - base.score;
        let added = rough.fitted.members.last().map(|member| &self.fit_problem.candidates[member.candidate]);
        let share = if added.is_some_and(CandidateEffect::has_shape) { SHAPELESS_SHARE } else { SHORT_SHARE };
        let hopeless = adds < HOPELESS - self.limits.rival_score;
        !hopeless && rough.score + share * adds.max(0.0) + SHORT >= top - self.limits.rival_score
    }
}
