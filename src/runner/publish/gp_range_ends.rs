//! Tells of Gaussian processes whose hyper-parameters ended at an end of their range.

use std::collections::BTreeMap;

use crate::data::TableRow;
use crate::rows::experiment::GpRow;

/// Kinds of ends that are told, most frequent first; the table holds all.
const MAX_TOLD: usize = 4;
/// How a table tells the noise at its least.
const LEAST_NOISE: &str = "noise variance low";

/// The sentence about the processes `rows` of an experiment; none where no hyper-parameter is at an
/// end of its range.
pub(super) fn notice<'a>(
    experiment: &str,
    has_prior: bool,
    rows: impl Iterator<Item = &'a GpRow> + Clone,
) -> Option<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for end in rows.clone().flat_map(|row| ends(row)) {
        *counts.entry(end).or_default() += 1;
    }
    let processes = rows.clone().filter(|row| ends(row).next().is_some()).count();
    if processes == 0 {
        return None;
    }
    let mut told: Vec<(&str, usize)> = counts.into_iter().collect();
    // What harms comes first, then what is frequent.
    told.sort_by_key(|(end, count)| (*end != LEAST_NOISE, std::cmp::Reverse(*count)));
    let further = told.len().saturating_sub(MAX_TOLD);
    told.truncate(MAX_TOLD);
    let mut list: Vec<String> =
        told.iter().map(|(end, count)| format!("{end}, {count} times")).collect();
    if further > 0 {
        list.push(format!("{further} others"));
    }
    let advice = match told.first() {
        Some((LEAST_NOISE, _)) if !has_prior => {
            "; with the noise at its least, intervals are too narrow: the tracker's noise as a prior, \
             `gp: {noise_prior: {}}`, prevents it"
        }
        Some((LEAST_NOISE, _)) => "; with the noise at its least, intervals are too narrow",
        _ => "",
    };
    Some(format!(
        "{experiment}: in {processes} of {} Gaussian processes a hyper-parameter is at an end of its \
         range ({}; column `at_range_end` of {}){advice}",
        rows.count(),
        list.join("; "),
        GpRow::TABLE.file
    ))
}

/// The ends of a process without their axes.
fn ends(row: &GpRow) -> impl Iterator<Item = &str> {
    let texts = row.score.at_range_end.split("; ").filter(|text| !text.is_empty());
    texts.map(|text| text.split_once(' ').map_or(text, |(_, end)| end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::experiment::GpScore;

    fn row(at_range_end: &str) -> GpRow {
        let score = GpScore {
            points: 40,
            kernel: "se_ard".to_owned(),
            cross_validation_mae_m: 0.0,
            log_marginal_likelihood: 0.0,
            noise_x_m: 0.0,
            noise_y_m: 0.0,
            noise_z_m: 0.0,
            at_range_end: at_range_end.to_owned(),
        };
        GpRow { seed: 0, training: "any".to_owned(), score }
    }

    #[test]
    fn one_sentence_counts_the_ends_and_the_noise_comes_first() {
        let rows = [
            row("x length 3 high; y noise variance low"),
            row(""),
            row("x length 3 high; z length 3 high"),
        ];
        assert_eq!(
            notice("one", false, rows.iter()).unwrap(),
            "one: in 2 of 3 Gaussian processes a hyper-parameter is at an end of its range (noise \
             variance low, 1 times; length 3 high, 3 times; column `at_range_end` of gp.csv); with \
             the noise at its least, intervals are too narrow: the tracker's noise as a prior, `gp: \
             {noise_prior: {}}`, prevents it"
        );
        assert!(!notice("one", true, rows.iter()).unwrap().contains("noise_prior"));
        assert!(notice("one", false, rows[1..2].iter()).is_none());
    }
}
