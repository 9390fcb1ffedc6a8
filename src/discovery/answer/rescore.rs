//! Rescoring of sets close to the best one at fine resolution: the search uses sensitivities
//! without effects and coarse time steps, which shift scores by some tens.

use std::collections::BTreeSet;

use super::final_fit::FinalFit;
use crate::discovery::fit::candidate::candidate_set;
use crate::discovery::problem::Problem;
use crate::discovery::search::{ScoredSet, Search};

/// Sets at most this far behind in score are rescored (docs/method/search.md, "Searching sets", step
/// 9).
const RESCORED_DISTANCE: f64 = 30.0;
/// Maximum number of rescored sets.
const MAX_RESCORED: usize = 4;

impl Problem<'_> {
    /// `best` with its final fit, or a close set that is better after rescoring and passes the
    /// tests that `best` passes. Rescored sets get their new scores in the `search`.
    pub(crate) fn rescore(
        &self,
        search: &mut Search,
        best: ScoredSet,
        final_fit: FinalFit,
    ) -> (ScoredSet, FinalFit) {
        let penalty = |scored: &ScoredSet| self.fit_problem().penalty(&scored.fitted.members);
        let best_deviance = final_fit.fine.fitted.nuisance_fit.deviance + penalty(&best);
        let mut near = search.close_to(&best);
        for scored in &mut near {
            let deviance = self.refit_finely(&scored.fitted).fitted.nuisance_fit.deviance;
            // Fine deviances are compared with the fine deviance of the best set, never with rough
            // ones.
            scored.score = best.score + best_deviance - deviance - penalty(scored);
        }
        search.replace_scores(&near);
        // Net scores compare sets of different sizes.
        let leading =
            near.into_iter().max_by(|a, b| search.net_score(a).total_cmp(&search.net_score(b)));
        let Some(leading) =
            leading.filter(|leading| search.net_score(leading) > search.net_score(&best))
        else {
            return (best, final_fit);
        };
        let other = self.final_fit(&leading.fitted);
        if other.goodness.failed.is_some() && final_fit.goodness.failed.is_none() {
            (best, final_fit)
        } else {
            (leading, other)
        }
    }
}

impl Search<'_> {
    /// Fully fitted sets close to `best` with no more effects.
    fn close_to(&self, best: &ScoredSet) -> Vec<ScoredSet> {
        let mut near: Vec<&ScoredSet> =
            self.tried.iter().filter(|scored| self.is_close_to(scored, best)).collect();
        near.sort_by(|a, b| self.net_score(b).total_cmp(&self.net_score(a)));
        let mut listed = BTreeSet::from([candidate_set(&best.fitted.members)]);
        near.retain(|scored| listed.insert(candidate_set(&scored.fitted.members)));
        // A rough score is a lower bound, so the full fit decides again whether the set is close.
        let fitted =
            |scored: &ScoredSet| if scored.exact { scored.clone() } else { self.fit_fully(scored) };
        near.into_iter()
            .take(MAX_RESCORED)
            .map(fitted)
            .filter(|scored| self.is_close_to(scored, best))
            .collect()
    }

    fn is_close_to(&self, scored: &ScoredSet, best: &ScoredSet) -> bool {
        let has_no_more = scored.fitted.members.len() <= best.fitted.members.len();
        has_no_more
            && !scored.fitted.members.is_empty()
            && self.net_score(scored) > self.net_score(best) - RESCORED_DISTANCE
    }

    /// Replaces the entries of these sets.
    fn replace_scores(&mut self, sets: &[ScoredSet]) {
        let replaced: BTreeSet<BTreeSet<usize>> =
            sets.iter().map(|scored| candidate_set(&scored.fitted.members)).collect();
        self.tried.retain(|scored| !replaced.contains(&candidate_set(&scored.fitted.members)));
        self.tried.extend_from_slice(sets);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discovery::fit::candidate::SetMember;
    use crate::discovery::fit::simulate::circling;
    use crate::discovery::options::Options;
    use crate::effects::{EffectSpec, Model};

    /// Data with a load; the search has it `load_ahead` of a heavier rod. Returns the entries of
    /// both after rescoring.
    fn rescored(load_ahead: f64, begin_with_load: bool) -> [Vec<ScoredSet>; 2] {
        let model = Model::default();
        let mut samples = circling(&model, &[EffectSpec::tip_load(0.006)]);
        let noise = samples.noise(3e-4, 0.0, 1);
        for (row, noise) in samples.rows.iter_mut().zip(noise.chunks_exact(3)) {
            row.position_m = std::array::from_fn(|axis| row.position_m[axis] + noise[axis]);
        }
        let options = Options::default();
        let problem = Problem::new(&model, samples, None, &options).unwrap();
        let fit_problem = problem.fit_problem();
        let mut search =
            Search::new(&fit_problem, Vec::new(), &options.limits(&model, 0.0)).unwrap();
        let fitted = |name: &str, value: f64| {
            let candidate =
                problem.candidates.iter().position(|one| one.card.name == name).unwrap();
            fit_problem.fit(vec![SetMember { candidate, values: vec![value] }]).unwrap()
        };
        let mut load = search.score(fitted("tip_load", 0.005));
        let mass = search.score(fitted("distributed_mass", 1.1));
        load.score = mass.score + load_ahead;
        search.tried = vec![load.clone(), mass.clone()];
        let best = if begin_with_load { load.clone() } else { mass.clone() };
        let final_fit = problem.final_fit(&best.fitted);
        let (best, final_fit) = problem.rescore(&mut search, best, final_fit);
        assert_eq!(final_fit.fine.fitted.members.len(), 1);
        let entries = |set: &ScoredSet| -> Vec<ScoredSet> {
            let all = search.tried.iter().chain([&best]);
            all.filter(|one| {
                candidate_set(&one.fitted.members) == candidate_set(&set.fitted.members)
            })
            .cloned()
            .collect()
        };
        [entries(&load), entries(&mass)]
    }

    #[test]
    fn what_was_behind_by_rough_scores_leads_if_it_is_better_and_what_leads_stays() {
        for (ahead, begin_with_load) in [(-10.0, false), (10.0, true), (-10.0, true)] {
            let [load, mass] = rescored(ahead, begin_with_load);
            assert_eq!((load.len(), mass.len()), (2, 1), "the load is the best one");
            assert!(load[1].score > mass[0].score + 5.0, "{} {}", load[1].score, mass[0].score);
        }
    }

    #[test]
    fn what_is_far_behind_is_not_judged() {
        let [load, mass] = rescored(-2.0 * RESCORED_DISTANCE, false);
        assert_eq!((load.len(), mass.len()), (1, 2));
        assert_eq!(load[0].score, mass[0].score - 2.0 * RESCORED_DISTANCE);
    }
}
