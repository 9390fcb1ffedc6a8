//! Blocks of rows that are held out together: patterns, or else trials, or else stretches of time.

use std::ops::Range;

use super::comparison::Comparison;
use crate::calibration::error::CalibrationError;
use crate::calibration::numbers::path::like;

/// Stretches of time into which a single trial is divided.
const STRETCHES: usize = 10;
/// Parts of a cross-validation.
const FOLDS: usize = 5;

/// What to hold out of the fit.
#[derive(Clone, Debug, PartialEq)]
pub enum HoldOut {
    /// Nothing: the error on unseen data is estimated by blocked cross-validation.
    CrossValidated,
    /// This share of the blocks, evenly spread over the recording, never the first.
    Share(f64),
    /// The patterns with these names; `*` stands for any text. With several recordings, the blocks
    /// `RECORDING/PATTERN`.
    Patterns(Vec<String>),
}

/// The blocks of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Blocks {
    /// What a block is: `pattern`, `trial`, `stretch of time`, or `block` where recordings differ.
    pub(crate) kind: &'static str,
    /// Their names.
    pub(crate) names: Vec<String>,
    /// Block of each sighting.
    pub(crate) of: Vec<usize>,
}

/// Sightings of a validation by their index.
#[derive(Clone, Copy)]
pub(crate) struct SightingSplit<'a> {
    /// Those that the fit sees.
    pub(crate) fitted: &'a [usize],
    /// Those whose error is measured.
    pub(crate) unseen: &'a [usize],
}

impl Blocks {
    /// Blocks of the sightings of `comparison`: of each recording by pattern where it has several,
    /// else by trial, else by time. With several recordings, `RECORDING/BLOCK`.
    pub(crate) fn new(comparison: &Comparison) -> Blocks {
        let each = &comparison.recordings.each;
        let of = |(name, rows): &(String, Range<usize>)| {
            let (kind, labels) = labels(comparison, rows);
            let whole = |label| if each.len() > 1 { format!("{name}/{label}") } else { label };
            (kind, labels.into_iter().map(whole).collect::<Vec<_>>())
        };
        let (kinds, labels): (Vec<&str>, Vec<Vec<String>>) = each.iter().map(of).unzip();
        let kind = if each.len() == 1 || kinds.iter().all(|kind| *kind == "pattern") {
            kinds[0]
        } else {
            "block"
        };
        Blocks::labelled(kind, labels.into_iter().flatten())
    }

    /// Blocks by label, in the order in which they appear.
    fn labelled(kind: &'static str, labels: impl Iterator<Item = String>) -> Blocks {
        let mut names: Vec<String> = Vec::new();
        let mut of = Vec::new();
        for label in labels {
            let same_as_last = of.last().copied().filter(|&last: &usize| names[last] == label);
            let block = same_as_last
                .or_else(|| names.iter().position(|name| *name == label))
                .unwrap_or_else(|| {
                    names.push(label);
                    names.len() - 1
                });
            of.push(block);
        }
        Blocks { kind, names, of }
    }

    /// The parts of a cross-validation: blocks that follow each other stay together, so that
    /// motions of one kind are held out together. One part a block where there are few.
    pub(crate) fn folds(&self) -> Vec<Vec<usize>> {
        let (count, folds) = (self.names.len(), self.names.len().min(FOLDS));
        // Contiguous: block k of n goes to part ⌊k · folds / n⌋.
        let fold = |block: usize| block * folds / count.max(1);
        let members = |wanted: usize| (0..count).filter(|&block| fold(block) == wanted).collect();
        (0..folds).map(members).collect()
    }

    /// The blocks to hold out for good.
    ///
    /// # Errors
    /// [`CalibrationError::HoldOut`] when nothing is left to fit or to hold out.
    pub(crate) fn held_out(&self, wanted: &HoldOut) -> Result<Vec<usize>, CalibrationError> {
        let count = self.names.len();
        let held: Vec<usize> = match wanted {
            HoldOut::CrossValidated => return Ok(Vec::new()),
            HoldOut::Share(share) => {
                let wanted = ((share * count as f64).round() as usize).clamp(1, count.max(2) - 1);
                // The last block of each equal part, so that the first is always fitted.
                (0..wanted).map(|k| ((k + 1) * count) / wanted - 1).collect()
            }
            HoldOut::Patterns(patterns) => {
                if matches!(self.kind, "trial" | "stretch of time") {
                    let words = "found no column `pattern` with several labels, expected one for \
                                 --hold-out-patterns";
                    return Err(CalibrationError::HoldOut(words.to_owned()));
                }
                for pattern in patterns {
                    if !self.names.iter().any(|name| like(pattern, name)) {
                        let names =
                            self.names.iter().take(8).cloned().collect::<Vec<_>>().join(", ");
                        let words = format!(
                            "--hold-out-patterns: found no pattern `{pattern}`, expected one of \
                             {names}"
                        );
                        return Err(CalibrationError::HoldOut(words));
                    }
                }
                let fits = |&block: &usize| {
                    patterns.iter().any(|pattern| like(pattern, &self.names[block]))
                };
                (0..count).filter(fits).collect()
            }
        };
        if held.len() == count {
            let words =
                format!("every {} would be held out, expected at least one for the fit", self.kind);
            return Err(CalibrationError::HoldOut(words));
        }
        Ok(held)
    }

    /// Indices of the sightings in these blocks, and of the others.
    pub(crate) fn parted(&self, held: &[usize]) -> (Vec<usize>, Vec<usize>) {
        (0..self.of.len()).partition(|&index| held.contains(&self.of[index]))
    }

    /// The blocks of some sightings, renumbered without gaps.
    pub(crate) fn only(&self, kept: &[usize]) -> Blocks {
        Blocks::labelled(self.kind, kept.iter().map(|&index| self.names[self.of[index]].clone()))
    }
}

/// What the blocks of one recording are, and the label of each of its sightings.
fn labels(comparison: &Comparison, rows: &Range<usize>) -> (&'static str, Vec<String>) {
    let recording = &comparison.recordings.joined;
    let of_rows = |label: &dyn Fn(usize) -> String| -> Vec<String> {
        let seen = comparison.sightings.iter().map(|sighting| sighting.row);
        seen.filter(|row| rows.contains(row)).map(label).collect()
    };
    let differ = |labels: &[String]| labels.windows(2).any(|pair| pair[0] != pair[1]);
    if let Some(patterns) = &recording.pattern {
        let patterns = of_rows(&|row| patterns[row].clone());
        if differ(&patterns) {
            return ("pattern", patterns);
        }
    }
    // Rows of one pattern or trial are alike; held out singly, neighbours would give them away.
    let trials = of_rows(&|row| recording.trial[row].to_string());
    if differ(&trials) {
        return ("trial", trials);
    }
    let stretch = |row: usize| ((row - rows.start) * STRETCHES / rows.len()).to_string();
    ("stretch of time", of_rows(&stretch))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(labels: &[&str]) -> Blocks {
        Blocks::labelled("pattern", labels.iter().map(|label| (*label).to_owned()))
    }

    #[test]
    fn folds_keep_neighbours_together() {
        let many = blocks(&["a", "b", "c", "d", "e", "f", "g", "a"]);
        assert_eq!(many.folds(), [vec![0, 1], vec![2], vec![3, 4], vec![5], vec![6]]);
        assert_eq!(many.parted(&[0]).0, [0, 7]);
        assert_eq!(blocks(&["a", "b"]).folds().len(), 2);
    }

    #[test]
    fn what_is_held_out_leaves_something_to_fit() {
        let four = blocks(&["pull_1", "pull_2", "circle_1", "circle_2"]);
        let names = |names: &[&str]| {
            HoldOut::Patterns(names.iter().map(|name| (*name).to_owned()).collect())
        };
        assert_eq!(four.held_out(&names(&["circle*"])).unwrap(), [2, 3]);
        assert_eq!(four.held_out(&HoldOut::Share(0.5)).unwrap(), [1, 3]);
        assert_eq!(four.held_out(&HoldOut::Share(0.01)).unwrap(), [3]);
        assert!(
            four.held_out(&names(&["*"])).is_err() && four.held_out(&names(&["spiral"])).is_err()
        );
    }
}
