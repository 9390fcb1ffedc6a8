//! Rows of a recording that say nothing about the robot: single-frame jumps of the tracker, poses
//! that repeat to the last bit while the robot moves, and rows after a gap in which commands are
//! missing.
//!
//! The rules compare a recording with the tip that a model predicts under the same commands. The
//! model may be wrong by any effect: only what no robot does counts.

mod frozen;
mod gaps;
mod jumps;

use std::collections::BTreeSet;

use crate::base::Point3;
use crate::data::Recording;

/// Above this share of suspicious rows none is excluded: a rule that finds so many has met a robot,
/// not a fault.
const MAX_EXCLUDED_SHARE: f64 = 0.1;

/// A row that is excluded.
#[derive(Clone, Debug, PartialEq)]
pub struct Exclusion {
    /// Row of the recording, from 0.
    pub row: usize,
    /// Why, as text.
    pub why: String,
}

/// Suspicious rows of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exclusions {
    /// Jumps of a tracked place that last up to three rows.
    pub jumps: Vec<Exclusion>,
    /// Repeated poses.
    pub frozen: Vec<Exclusion>,
    /// Rows after gaps.
    pub gaps: Vec<Exclusion>,
}

impl Exclusions {
    /// Finds the suspicious rows of `measured`. `predicted_m`: tip of a model in each row, metres;
    /// rows without a tip are ignored.
    pub fn find(measured: &Recording, predicted_m: &[Point3]) -> Exclusions {
        measured.tip_m.as_ref().map_or_else(Exclusions::default, |tips_m| {
            Exclusions::find_at(measured, tips_m, "the tip", predicted_m)
        })
    }

    /// The same of another tracked place, called `what`, that was measured at `positions_m` in each
    /// row.
    pub fn find_at(
        measured: &Recording,
        positions_m: &[Point3],
        what: &str,
        predicted_m: &[Point3],
    ) -> Exclusions {
        let is_seen =
            |row: usize| measured.is_valid(row) && positions_m[row].iter().all(|x| x.is_finite());
        let rows = |range: std::ops::Range<usize>| {
            range.filter(|&row| is_seen(row)).collect::<Vec<usize>>()
        };
        let trials: Vec<Vec<usize>> =
            measured.trials().into_iter().map(|(_, range)| rows(range)).collect();
        let all: usize = trials.iter().map(Vec::len).sum();
        let unless_many = |exclusions: Vec<Exclusion>| {
            if exclusions.len() as f64 > MAX_EXCLUDED_SHARE * all as f64 {
                Vec::new()
            } else {
                exclusions
            }
        };
        let (frozen, gaps) = (
            unless_many(frozen::find(measured, positions_m, predicted_m, &trials)),
            unless_many(gaps::find(measured)),
        );
        let is_kept = |row: &usize| frozen.iter().chain(&gaps).all(|excluded| excluded.row != *row);
        let kept: Vec<Vec<usize>> =
            trials.iter().map(|rows| rows.iter().copied().filter(is_kept).collect()).collect();
        let jumps = unless_many(jumps::find(what, positions_m, predicted_m, &kept));
        Exclusions { jumps, frozen, gaps }
    }

    /// Adds those of `other` whose rows are not excluded already.
    pub fn extend(&mut self, other: Exclusions) {
        let excluded_rows: BTreeSet<usize> = self.all().map(|excluded| excluded.row).collect();
        let add = |exclusions: &mut Vec<Exclusion>, further: Vec<Exclusion>| {
            exclusions.extend(
                further.into_iter().filter(|excluded| !excluded_rows.contains(&excluded.row)),
            );
            exclusions.sort_by_key(|excluded| excluded.row);
        };
        add(&mut self.jumps, other.jumps);
        add(&mut self.frozen, other.frozen);
        add(&mut self.gaps, other.gaps);
    }

    /// True when no row is excluded.
    pub fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }

    /// All excluded rows.
    pub fn all(&self) -> impl Iterator<Item = &Exclusion> {
        self.jumps.iter().chain(&self.frozen).chain(&self.gaps)
    }

    /// `measured` with the excluded rows marked as not tracked. Their commands stay.
    pub fn without(&self, measured: &Recording) -> Recording {
        let mut valid = measured.valid.clone().unwrap_or_else(|| vec![true; measured.len()]);
        self.all().for_each(|excluded| valid[excluded.row] = false);
        Recording { valid: Some(valid), ..measured.clone() }
    }

    /// What was excluded, and which rows of `measured`: one sentence a kind.
    pub fn sentences(&self, measured: &Recording) -> Vec<String> {
        let kinds = [
            (
                &self.jumps,
                "the tracked position jumps and returns within three rows, which indicates a \
                 tracker error",
            ),
            (&self.frozen, "the pose is identical to an earlier one while the robot moves"),
            (&self.gaps, "rows and their commands are missing in the preceding second"),
        ];
        let present = kinds.into_iter().filter(|(rows, _)| !rows.is_empty());
        let sentence = |(rows, what): (&Vec<Exclusion>, &str)| {
            let (count, all, which) = (rows.len(), measured.len(), places(rows, measured));
            format!("In {count} of {all} rows {what} ({which}); these rows were excluded.")
        };
        present.map(sentence).collect()
    }
}

/// Most runs of rows that a sentence names.
const MAX_NAMED_PLACES: usize = 6;

/// Trials and times of `rows`, neighbouring ones together.
fn places(rows: &[Exclusion], measured: &Recording) -> String {
    let runs: Vec<&[Exclusion]> = rows
        .chunk_by(|a, b| a.row + 1 == b.row && measured.trial[a.row] == measured.trial[b.row])
        .collect();
    let place = |run: &&[Exclusion]| {
        let (first, last) = (run[0].row, run[run.len() - 1].row);
        let to =
            if first == last { String::new() } else { format!(" to {}", measured.time_s[last]) };
        format!("trial {} at {}{to} s", measured.trial[first], measured.time_s[first])
    };
    let mut named: Vec<String> = runs.iter().take(MAX_NAMED_PLACES).map(place).collect();
    if runs.len() > MAX_NAMED_PLACES {
        named.push(format!("{} more places", runs.len() - MAX_NAMED_PLACES));
    }
    named.join(", ")
}

/// The difference of two points.
fn difference_m(a: &Point3, b: &Point3) -> Point3 {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn length(v: &Point3) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn dot(a: &Point3, b: &Point3) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A robot whose tip follows circles, three trials of 60 rows at 5 Hz, measured with noise of 0.5
/// mm an axis, and the tip that a model without its sag of 5 mm predicts.
#[cfg(test)]
fn circles() -> (Recording, Vec<Point3>) {
    use crate::data::Actuation;
    use rand_distr::{Distribution, Normal};

    let (mut random, noise) = (crate::base::Seed(3).rng(), Normal::new(0.0, 5e-4).unwrap());
    let mut measured = Recording::new(Actuation::Lengths, 2);
    let (mut tips_m, mut predicted_m) = (Vec::new(), Vec::new());
    for trial in 0..3_u32 {
        for row in 0..60_u32 {
            let angle = 0.3 * f64::from(row) * (1.0 + 0.1 * f64::from(trial));
            let tip_m = [0.03 * angle.sin(), 0.03 * (1.7 * angle).sin(), 0.2];
            measured.trial.push(u64::from(trial));
            measured.time_s.push(0.2 * f64::from(row));
            measured.commands.push(&[tip_m[0] / 5.0, tip_m[1] / 5.0]);
            predicted_m.push(tip_m);
            tips_m.push(std::array::from_fn(|axis| {
                tip_m[axis] - if axis == 0 { 5e-3 } else { 0.0 } + noise.sample(&mut random)
            }));
        }
    }
    measured.tip_m = Some(tips_m);
    (measured, predicted_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clean_rows_stay_whatever_the_model_lacks() {
        let (measured, predicted_m) = circles();
        assert!(Exclusions::find(&measured, &predicted_m).is_empty());
        // A model that is late by a row, and one that is too stiff by half.
        let late: Vec<Point3> =
            (0..predicted_m.len()).map(|row| predicted_m[row.saturating_sub(1)]).collect();
        assert!(Exclusions::find(&measured, &late).is_empty());
        let stiff: Vec<Point3> =
            predicted_m.iter().map(|tip| [0.5 * tip[0], 0.5 * tip[1], tip[2]]).collect();
        assert!(Exclusions::find(&measured, &stiff).is_empty());
    }

    #[test]
    fn excluded_rows_keep_their_commands_and_are_told() {
        let (mut measured, predicted_m) = circles();
        measured.tip_m.as_mut().unwrap()[70][1] += 0.02;
        let excluded = Exclusions::find(&measured, &predicted_m);
        let without = excluded.without(&measured);
        assert_eq!(
            (0..measured.len()).filter(|&row| !without.is_valid(row)).collect::<Vec<_>>(),
            [70]
        );
        assert_eq!(without.commands, measured.commands);
        let told = &excluded.sentences(&measured)[0];
        assert!(
            told.starts_with("In 1 of 180 rows the tracked position jumps")
                && told.contains("(trial 1 at 2 s)"),
            "{told}"
        );
    }

    /// A rule that would exclude much of a recording excludes nothing.
    #[test]
    fn many_suspicious_rows_are_no_outliers() {
        let (mut measured, predicted_m) = circles();
        for row in (2..180).step_by(6) {
            measured.tip_m.as_mut().unwrap()[row][2] += 0.03;
        }
        assert!(Exclusions::find(&measured, &predicted_m).is_empty());
    }
}
