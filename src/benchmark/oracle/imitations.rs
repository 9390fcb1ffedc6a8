//! Which sets of effects imitate a change of the tip equally well: where there is one alone, no data can make a group of it.

use std::collections::BTreeSet;

use super::{CatalogueSpan, EffectResponse, EffectSet, rms};
use crate::benchmark::commands::Commands;
use crate::benchmark::injection::injected_effects::card;
use crate::benchmark::options::OracleOptions;
use crate::effects::{Model, Seek};

/// Sets of one size that are refitted.
const REFITTED: usize = 8;
/// Squares over the noise that are so close are expected to be equally likely, as `rival_score` has it.
const ALIKE: f64 = 6.0;

impl CatalogueSpan {
    /// The sets of as few effects as can be that imitate `moved` (three numbers a sample, metres), the best first: those that
    /// leave no more than rivals may beyond the best of their size, the smallest at which that is inside the span. None
    /// where no set of up to `most_effects` is. `left_out`: effects that may not be taken.
    pub fn imitations(
        &self,
        model: &Model,
        commands: &Commands,
        moved: &[f64],
        left_out: &[String],
        options: &OracleOptions,
    ) -> Vec<String> {
        let Some(refit) = self.refit(model, commands, moved) else { return Vec::new() };
        let (metric, wanted) = (&refit.metric, &refit.wanted);
        let of_size = |effects: usize| {
            let sets = self.distinct_sets(self.sets(metric, wanted, left_out, effects));
            let refitted = sets.into_iter().map(|(name, set)| (refit.remaining_square(self.members(&set)), name));
            let mut refitted: Vec<(f64, String)> = refitted.collect();
            refitted.sort_by(|a, b| a.0.total_cmp(&b.0));
            let least = refitted.first().filter(|(square, _)| rms(*square, wanted.len()) < options.inside_below)?.0;
            refitted.retain(|(square, _)| *square < least + ALIKE);
            Some(refitted.into_iter().map(|(_, name)| name).collect())
        };
        (1..=options.most_effects).find_map(of_size).unwrap_or_default()
    }

    /// The first few of `sets` that are of other effects or tendons, with their names: places and shapes make no other set,
    /// and no effect is taken twice.
    fn distinct_sets(&self, sets: Vec<EffectSet>) -> Vec<(String, EffectSet)> {
        let mut seen = BTreeSet::new();
        let named = sets.into_iter().filter_map(|set| {
            let names: BTreeSet<String> = set.responses.iter().map(|&k| self.responses[k].label()).collect();
            let new = names.len() == set.responses.len() && seen.insert(names.clone());
            new.then(|| (names.into_iter().collect::<Vec<String>>().join(" + "), set))
        });
        named.take(REFITTED).collect()
    }
}

impl EffectResponse {
    /// Its effect, and the tendon where it is about one.
    fn label(&self) -> String {
        let tendon = card(&self.name)
            .and_then(|card| card.parameters.iter().position(|parameter| parameter.seek == Seek::Tendon));
        tendon.map_or_else(|| self.name.clone(), |index| format!("{} (tendon {})", self.name, self.null[index]))
    }
}
