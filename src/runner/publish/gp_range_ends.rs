//! Tells of Gaussian processes whose hyper-parameters ended at an end of their range.

use std::collections::BTreeMap;

use crate::data::TableRow;
use crate::rows::experiment::GpRow;

/// How a table tells the noise at its least.
const LEAST_NOISE: &str = "noise variance low";
/// What length-scales at their most are.
const WITHOUT_INFLUENCE: &str = "length-scales of inputs without influence";

/// What is told of hyper-parameters at an end of their range.
#[derive(Debug)]
pub(super) struct RangeEndsNote {
    pub(super) sentence: String,
    /// Whether noise is among them, which makes intervals too narrow.
    pub(super) is_warning: bool,
}

/// The sentence about the processes `rows` of an experiment; none where no hyper-parameter is at an
/// end of its range.
pub(super) fn note<'a>(
    experiment: &str,
    has_prior: bool,
    rows: impl Iterator<Item = &'a GpRow> + Clone,
) -> Option<RangeEndsNote> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for end in rows.clone().flat_map(ends) {
        *counts.entry(end).or_default() += 1;
    }
    if counts.is_empty() {
        return None;
    }
    let without_noise = counts.contains_key(LEAST_NOISE);
    let mut told: Vec<(&str, usize)> = counts.into_iter().collect();
    // What harms comes first, what is as it should be last.
    told.sort_by_key(|(end, count)| {
        (*end != LEAST_NOISE, *end == WITHOUT_INFLUENCE, std::cmp::Reverse(*count))
    });
    let list: Vec<String> = told.iter().map(|(end, count)| format!("{end}: {count}")).collect();
    let advice = match (without_noise, has_prior) {
        (false, _) => "",
        (true, true) => "; a noise variance at its lower end makes intervals too narrow",
        (true, false) => {
            "; a noise variance at its lower end makes intervals too narrow; the tracker's noise \
             as a prior prevents this: `gp: {noise_prior: {}}`"
        }
    };
    let sentence = format!(
        "{experiment}: of {} Gaussian processes, hyper-parameters at an end of their range are {} \
         (column `at_range_end` of {}){advice}",
        rows.clone().count(),
        list.join(", "),
        GpRow::TABLE.file
    );
    Some(RangeEndsNote { sentence, is_warning: without_noise })
}

/// The ends of a process without their axes; all length-scales at their most are one kind.
fn ends(row: &GpRow) -> impl Iterator<Item = &str> {
    let texts = row.score.at_range_end.split("; ").filter(|text| !text.is_empty());
    let ends = texts.map(|text| text.split_once(' ').map_or(text, |(_, end)| end));
    ends.map(|end| {
        let is_long = end.starts_with("length") && end.ends_with("high");
        if is_long { WITHOUT_INFLUENCE } else { end }
    })
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
            row("z signal variance high"),
            row("x length 3 high; z length 4 high"),
            row(""),
        ];
        assert_eq!(
            note("one", false, rows.iter()).unwrap().sentence,
            "one: of 4 Gaussian processes, hyper-parameters at an end of their range are noise \
             variance low: 1, signal variance high: 1, length-scales of inputs without influence: \
             3 (column `at_range_end` of gp.csv); a noise variance at its lower end makes \
             intervals too narrow; the tracker's noise as a prior prevents this: `gp: \
             {noise_prior: {}}`"
        );
        let known = note("one", true, rows.iter()).unwrap();
        assert!(known.is_warning && !known.sentence.contains("noise_prior"));
        assert!(!note("one", true, rows[1..].iter()).unwrap().is_warning);
        assert!(note("one", false, rows[3..].iter()).is_none());
    }
}
