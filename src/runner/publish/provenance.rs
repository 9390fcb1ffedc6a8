//! The trail of an experiment: every stage behind its results, in an order in which each follows
//! its inputs. It is what names the first stage at which two runs part.

use crate::rows::experiment::StageRow;
use crate::runner::campaign::{Campaign, CampaignEntry};
use crate::runner::execute::outcomes::Outcomes;
use crate::runner::store::Store;
use std::collections::BTreeSet;

/// The numbers of all stages behind what an experiment publishes.
pub(crate) fn stages_behind(campaign: &Campaign, entry: &CampaignEntry) -> BTreeSet<usize> {
    with_inputs(campaign, entry.wanted())
}

/// These stages and all before them.
pub(super) fn with_inputs(campaign: &Campaign, mut needed: BTreeSet<usize>) -> BTreeSet<usize> {
    for number in (0..campaign.graph.len()).rev() {
        if needed.contains(&number) {
            needed.extend(campaign.graph.inputs(number));
        }
    }
    needed
}

/// The trail of `entry` after a run: digests as they stand in the store, times of this run or as
/// they were noted.
pub fn provenance(
    campaign: &Campaign,
    entry: &CampaignEntry,
    outcomes: &Outcomes,
    store: &Store,
) -> Vec<StageRow> {
    let row = |number: usize| {
        let (stage, label, key) = campaign.graph.describe(number);
        let noted = || store.noted(stage, &key).map(|note| note.timing);
        let timing = outcomes.timings[number].or_else(noted).unwrap_or_default();
        StageRow {
            stage: stage.to_owned(),
            label: label.to_owned(),
            key: key.short(),
            result: store.digest(stage, &key).map(|digest| digest.short()).unwrap_or_default(),
            wall_s: timing.wall_s,
            cpu_s: timing.cpu_s,
        }
    };
    stages_behind(campaign, entry).into_iter().map(row).collect()
}

/// The first stage at which a run parts from a published trail, in words; `None` where they go
/// together.
pub fn first_difference(published: &[StageRow], found: &[StageRow]) -> Option<String> {
    first_parting(published, found, ["published", "found"])
}

/// The first stage at which two trails part, which these words name.
pub(super) fn first_parting(
    first: &[StageRow],
    second: &[StageRow],
    [one, other]: [&str; 2],
) -> Option<String> {
    for (before, now) in first.iter().zip(second) {
        let name = format!("{} ({})", now.stage, now.label);
        if (&before.stage, &before.label) != (&now.stage, &now.label) {
            return Some(format!(
                "{name}: the {one} stage at this position is {} ({})",
                before.stage, before.label
            ));
        }
        if before.result != now.result && !before.result.is_empty() && !now.result.is_empty() {
            let (key, was, is) = (&now.key, &before.result, &now.result);
            let why = if before.key == *key {
                "the same settings and code"
            } else {
                "other settings or other code"
            };
            return Some(format!("{name}: {one} {was}, {other} {is}, with {why}"));
        }
    }
    let (before, now) = (first.len(), second.len());
    (before != now).then(|| format!("{other} {now} stages, {one} {before}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(stage: &str, key: &str, result: &str) -> StageRow {
        let (stage, key, result) = (stage.to_owned(), key.to_owned(), result.to_owned());
        StageRow { stage, label: "seed 0".into(), key, result, wall_s: 1.0, cpu_s: 1.0 }
    }

    #[test]
    fn the_first_stage_that_differs_is_named() {
        let published = [row("a", "1", "x"), row("b", "2", "y"), row("c", "3", "z")];
        assert_eq!(first_difference(&published, &published), None);
        let mut other = published.clone();
        other[2] = row("c", "3", "w");
        other[1] = row("b", "2", "w");
        let said = first_difference(&published, &other).unwrap();
        assert_eq!(said, "b (seed 0): published y, found w, with the same settings and code");
        other[1] = row("b", "9", "y");
        assert!(
            first_difference(&published, &other).unwrap().starts_with("c (seed 0)"),
            "another key alone is no difference"
        );
        assert_eq!(
            first_difference(&published, &published[..2]).unwrap(),
            "found 2 stages, published 3"
        );
        let said = first_difference(&published, &[row("q", "1", "x")]).unwrap();
        assert!(said.contains("the published stage at this position is a (seed 0)"), "{said}");
    }
}
