//! Sets of effects that imitate a tip displacement equally well. If there is only one, the data
//! cannot yield a group.

use std::collections::BTreeSet;

use super::{CatalogueSpan, EffectResponse, EffectSet, Imitated, rms};
use crate::benchmark::injection::injected_effects::{effect_label, tendon_parameter};
use crate::effects::card;

/// Number of sets of one size that are refitted.
const MAX_REFITTED_SETS: usize = 8;
/// Differences of squares over the noise within which sets count as equal, like `rival_score`.
const RIVAL_MARGIN: f64 = 6.0;

impl CatalogueSpan {
    /// The smallest sets that imitate a displacement, best first: at the smallest size that is
    /// inside the span, all sets within the rival margin. Empty if no set of up to `most_effects`
    /// is.
    pub fn imitations(&self, imitated: &Imitated) -> Vec<String> {
        let Some(refit) = self.refit(imitated) else { return Vec::new() };
        let Imitated { left_out, options, .. } = imitated;
        let (metric, target) = (&refit.metric, &refit.target);
        let of_size = |effects: usize| {
            let sets = self.distinct_sets(self.sets(metric, target, left_out, effects));
            let refitted = sets
                .into_iter()
                .map(|(name, set)| (refit.remaining_square(self.members(&set)), name));
            let mut refitted: Vec<(f64, String)> = refitted.collect();
            refitted.sort_by(|a, b| a.0.total_cmp(&b.0));
            let best = refitted
                .first()
                .filter(|(square, _)| rms(*square, target.len()) < options.inside_below)?
                .0;
            refitted.retain(|(square, _)| *square < best + RIVAL_MARGIN);
            Some(refitted.into_iter().map(|(_, name)| name).collect())
        };
        (1..=options.most_effects).find_map(of_size).unwrap_or_default()
    }

    /// The first few of `sets` that differ in effects or tendons, with their names; no effect
    /// twice.
    fn distinct_sets(&self, sets: Vec<EffectSet>) -> Vec<(String, EffectSet)> {
        let mut listed = BTreeSet::new();
        let named = sets.into_iter().filter_map(|set| {
            let names: BTreeSet<String> =
                set.responses.iter().map(|&k| self.responses[k].label()).collect();
            let is_new = names.len() == set.responses.len() && listed.insert(names.clone());
            is_new.then(|| (names.into_iter().collect::<Vec<String>>().join(" + "), set))
        });
        named.take(MAX_REFITTED_SETS).collect()
    }
}

impl EffectResponse {
    /// Name of the effect, with its tendon if it acts on one.
    fn label(&self) -> String {
        let tendon = card(&self.name).and_then(tendon_parameter).map(|index| self.null[index]);
        effect_label(&self.name, tendon)
    }
}
