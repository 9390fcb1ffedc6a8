//! Sets of effects that imitate a tip displacement equally well. If there is only one, the data cannot yield a group.

use std::collections::BTreeSet;

use super::{CatalogueSpan, EffectResponse, EffectSet, rms};
use crate::benchmark::commands::Commands;
use crate::benchmark::injection::injected_effects::card;
use crate::benchmark::options::OracleOptions;
use crate::effects::{Model, Seek};

/// Number of sets of one size that are refitted.
const REFITTED: usize = 8;
/// Differences of squares over the noise within which sets count as equal, like `rival_score`.
const ALIKE: f64 = 6.0;

impl CatalogueSpan {
    /// The smallest sets that imitate `moved` (three values a sample, metres), best first: at the smallest size that
    /// is inside the span, all sets within the rival margin. Empty if no set of up to `most_effects` is. `left_out`:
    /// excluded effects.
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

    /// The first few of `sets` that differ in effects or tendons, with their names; no effect twice.
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
    /// Name of the effect, with its tendon if it acts on one.
    fn label(&self) -> String {
        let tendon = card(&self.name)
            .and_then(|card| card.parameters.iter().position(|parameter| parameter.seek == Seek::Tendon));
        tendon.map_or_else(|| self.name.clone(), |index| format!("{} (tendon {})", self.name, self.null[index]))
    }
}
