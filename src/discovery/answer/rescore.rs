//! Sets that come near the best one, judged as finely as that: the search compares fits whose uncertain numbers answer as they
//! do without any effect, and on its own steps in time, which moves scores by some tens.

use std::collections::BTreeSet;

use super::final_fit::About;
use crate::discovery::fit::candidate::set_of;
use crate::discovery::problem::Question;
use crate::discovery::search::{Scored, Search};

/// Scores of the search that are this far behind may be ahead when they are judged finely.
const REACH: f64 = 30.0;
/// Sets that are judged at most.
const MOST: usize = 4;

impl Question<'_> {
    /// `best` and all about it, or a set that comes near it and is better once both are judged finely, which leaves nothing
    /// that `best` does not. Those that were judged have such scores in the `search` from then on.
    pub(crate) fn judged(&self, search: &mut Search, best: Scored, about: About) -> (Scored, About) {
        let costs = |scored: &Scored| self.study().penalty(&scored.fitted.members);
        let own = about.fine.fitted.explained.deviance + costs(&best);
        let mut near = search.near(&best);
        for scored in &mut near {
            let deviance = self.finely(&scored.fitted).fitted.explained.deviance;
            scored.score = best.score + own - deviance - costs(scored);
        }
        search.known_better(&near);
        let leading = near.into_iter().max_by(|a, b| search.net(a).total_cmp(&search.net(b)));
        let Some(leading) = leading.filter(|leading| search.net(leading) > search.net(&best)) else {
            return (best, about);
        };
        let other = self.about(&leading.fitted);
        if other.left.certainly() && !about.left.certainly() { (best, about) } else { (leading, other) }
    }
}

impl Search<'_> {
    /// What was tried with no more effects than `best` and comes near it, the best of each set, fitted as well as can be.
    fn near(&self, best: &Scored) -> Vec<Scored> {
        let mut near: Vec<&Scored> = self.tried.iter().filter(|scored| self.is_near(scored, best)).collect();
        near.sort_by(|a, b| self.net(b).total_cmp(&self.net(a)));
        let mut seen = BTreeSet::from([set_of(&best.fitted.members)]);
        near.retain(|scored| seen.insert(set_of(&scored.fitted.members)));
        let settled = |scored: &Scored| if scored.exact { scored.clone() } else { self.settled(scored) };
        near.into_iter().take(MOST).map(settled).filter(|scored| self.is_near(scored, best)).collect()
    }

    fn is_near(&self, scored: &Scored, best: &Scored) -> bool {
        let no_more = scored.fitted.members.len() <= best.fitted.members.len();
        no_more && !scored.fitted.members.is_empty() && self.net(scored) > self.net(best) - REACH
    }

    /// Puts sets in the place of all that was known of them.
    fn known_better(&mut self, sets: &[Scored]) {
        let better: BTreeSet<BTreeSet<usize>> = sets.iter().map(|scored| set_of(&scored.fitted.members)).collect();
        self.tried.retain(|scored| !better.contains(&set_of(&scored.fitted.members)));
        self.tried.extend_from_slice(sets);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discovery::fit::candidate::Member;
    use crate::discovery::fit::simulate::circling;
    use crate::discovery::options::Options;
    use crate::effects::{EffectSpec, Model};

    /// Under a load, which the search has with the `load_ahead` of a heavier rod: what it has of both after they were judged.
    fn judged(load_ahead: f64, begin_with_load: bool) -> [Vec<Scored>; 2] {
        let model = Model::default();
        let mut samples = circling(&model, &[EffectSpec::tip_load(0.006)]);
        let noise = samples.noise(3e-4, 0.0, 1);
        for (row, noise) in samples.rows.iter_mut().zip(noise.chunks_exact(3)) {
            row.tip_m = std::array::from_fn(|axis| row.tip_m[axis] + noise[axis]);
        }
        let options = Options::default();
        let question = Question::new(&model, samples, None, &options).unwrap();
        let study = question.study();
        let mut search = Search::new(&study, Vec::new(), &options.limits(&model)).unwrap();
        let fitted = |name: &str, value: f64| {
            let hypothesis = question.hypotheses.iter().position(|one| one.card.name == name).unwrap();
            study.fit(vec![Member { hypothesis, values: vec![value] }]).unwrap()
        };
        let mut load = search.scored(fitted("tip_load", 0.005));
        let mass = search.scored(fitted("distributed_mass", 1.1));
        load.score = mass.score + load_ahead;
        search.tried = vec![load.clone(), mass.clone()];
        let best = if begin_with_load { load.clone() } else { mass.clone() };
        let about = question.about(&best.fitted);
        let (best, about) = question.judged(&mut search, best, about);
        assert_eq!(about.fine.fitted.members.len(), 1);
        let of = |own: &Scored| -> Vec<Scored> {
            let all = search.tried.iter().chain([&best]);
            all.filter(|one| set_of(&one.fitted.members) == set_of(&own.fitted.members)).cloned().collect()
        };
        [of(&load), of(&mass)]
    }

    #[test]
    fn what_was_behind_by_rough_scores_leads_if_it_is_better_and_what_leads_stays() {
        for (ahead, begin_with_load) in [(-10.0, false), (10.0, true), (-10.0, true)] {
            let [load, mass] = judged(ahead, begin_with_load);
            assert_eq!((load.len(), mass.len()), (2, 1), "the load is the best one");
            assert!(load[1].score > mass[0].score + 5.0, "{} {}", load[1].score, mass[0].score);
        }
    }

    #[test]
    fn what_is_far_behind_is_not_judged() {
        let [load, mass] = judged(-2.0 * REACH, false);
        assert_eq!((load.len(), mass.len()), (1, 2));
        assert_eq!(load[0].score, mass[0].score - 2.0 * REACH);
    }
}
