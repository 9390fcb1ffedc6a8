//! The figures of the benchmark, each with its 95 % interval and beside it what was to be reached.

use serde::Serialize;

use super::cases::{alarmed, gap_closed, in_catalogue};
use super::share::{IntervalEstimate, median, wilson};
use crate::data::findings::{CaseRow, OR};
use crate::report::order::ascending;
use MeasureKind::{Counts, Median, Share};

/// One figure over one part of the cases (`summary.csv`).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct SummaryRow {
    /// Which cases: `all`, `400 samples`, `noise 0.5 mm`.
    pub(crate) part: String,
    /// What is measured.
    pub(crate) measure: String,
    /// Cases (for intervals: parameters) behind it.
    pub(crate) cases: u64,
    pub(crate) value: f64,
    pub(crate) low_95: f64,
    pub(crate) high_95: f64,
    /// `share` (Wilson's interval) or `median` (order statistics).
    pub(crate) kind: String,
    /// What was to be reached, in words; empty where nothing was set.
    pub(crate) goal: String,
    /// Ends of what was to be reached; empty where there is none.
    pub(crate) goal_low: f64,
    pub(crate) goal_high: f64,
    /// `met` or `not met` by the value; empty where nothing was set.
    pub(crate) verdict: String,
}

/// What is measured of a case.
#[derive(Clone, Copy)]
enum MeasureKind {
    /// Whether it holds.
    Share(fn(&CaseRow) -> bool),
    /// Hits and trials of the case.
    Counts(fn(&CaseRow) -> [u64; 2]),
    /// A number; those that are not there are left out.
    Median(fn(&CaseRow) -> f64),
}

/// A figure of the benchmark.
struct Measure {
    name: &'static str,
    /// Which cases it is about.
    about: fn(&CaseRow) -> bool,
    kind: MeasureKind,
    /// What is to be reached.
    goal: Option<[f64; 2]>,
}

/// A tip that moves less than this is not expected to be seen through, metres.
const MIN_VISIBLE_SHIFT_M: f64 = 0.002;
/// Held-out error that counts as down to the noise, times the floor.
const MAX_RATIO_AT_FLOOR: f64 = 1.10;
const UNBOUNDED: f64 = f64::INFINITY;

fn single(case: &CaseRow) -> bool {
    case.group == "single"
}

fn shifted(case: &CaseRow, low_m: f64, high_m: f64) -> bool {
    single(case) && case.shift_m >= low_m && case.shift_m < high_m
}

fn nothing(case: &CaseRow) -> bool {
    case.group == "nothing"
}

fn right(case: &CaseRow) -> bool {
    case.right
}

fn in_group(case: &CaseRow) -> bool {
    case.in_group
}

/// Whether the oracle was asked which sets imitate what is hidden.
fn has_imitations(case: &CaseRow) -> bool {
    !case.imitations.is_empty()
}

/// Whether there is one such set alone, so that no group is to be told.
fn one_imitation(case: &CaseRow) -> bool {
    !case.imitations.contains(OR)
}

/// A refit of the stiffness cannot be beaten where the stiffness alone is off.
fn beats_stiffness_about(case: &CaseRow) -> bool {
    in_catalogue(case) && case.truth != "bending_stiffness" && case.stiffness_only_m.is_finite()
}

fn beats_stiffness(case: &CaseRow) -> bool {
    case.after_m < case.stiffness_only_m
}

fn has_gp(case: &CaseRow) -> bool {
    in_catalogue(case) && case.gp_m.is_finite()
}

fn beats_gp(case: &CaseRow) -> bool {
    case.after_m < case.gp_m
}

/// Whether what is hidden moves the tip far enough to be expected to be seen.
fn clearly_visible(case: &CaseRow) -> bool {
    case.shift_m >= MIN_VISIBLE_SHIFT_M
}

const fn measure(
    name: &'static str,
    about: fn(&CaseRow) -> bool,
    kind: MeasureKind,
    goal: Option<[f64; 2]>,
) -> Measure {
    Measure { name, about, kind, goal }
}

/// Every figure, in the order of the table; the goals are those of `docs/evidence/blind_benchmark.md`.
const MEASURES: &[Measure] = &[
    measure(
        "single effects of 2 mm and more named right",
        |c| single(c) && clearly_visible(c),
        Share(right),
        Some([0.95, 1.0]),
    ),
    measure(
        "… or in the answer’s group",
        |c| single(c) && clearly_visible(c),
        Share(in_group),
        Some([0.98, 1.0]),
    ),
    measure(
        "single effects of 5 mm and more: named right",
        |c| shifted(c, 0.005, UNBOUNDED),
        Share(right),
        None,
    ),
    measure(
        "single effects of 5 mm and more: in the group",
        |c| shifted(c, 0.005, UNBOUNDED),
        Share(in_group),
        None,
    ),
    measure(
        "single effects of 2 to 5 mm: named right",
        |c| shifted(c, 0.002, 0.005),
        Share(right),
        None,
    ),
    measure(
        "single effects of 2 to 5 mm: in the group",
        |c| shifted(c, 0.002, 0.005),
        Share(in_group),
        None,
    ),
    measure(
        "single effects of 1 to 2 mm: named right",
        |c| shifted(c, 0.001, 0.002),
        Share(right),
        None,
    ),
    measure(
        "single effects of 1 to 2 mm: in the group",
        |c| shifted(c, 0.001, 0.002),
        Share(in_group),
        None,
    ),
    measure(
        "single effects under 1 mm: named right",
        |c| shifted(c, 0.0, 0.001),
        Share(right),
        None,
    ),
    measure(
        "single effects under 1 mm: in the group",
        |c| shifted(c, 0.0, 0.001),
        Share(in_group),
        None,
    ),
    measure("pairs named exactly", |c| c.group == "pair", Share(right), Some([0.85, 1.0])),
    measure("pairs in the answer’s group", |c| c.group == "pair", Share(in_group), None),
    measure("false alarms", nothing, Share(alarmed), Some([0.0, 0.01])),
    measure(
        "false alarms in white noise",
        |c| nothing(c) && c.correlation == 0.0,
        Share(alarmed),
        None,
    ),
    measure(
        "false alarms in coloured noise",
        |c| nothing(c) && c.correlation != 0.0,
        Share(alarmed),
        None,
    ),
    measure(
        "unknown and outside the span: unexplained",
        |c| c.group == "outside",
        Share(right),
        Some([0.95, 1.0]),
    ),
    measure(
        "unknown and inside the span: a group",
        |c| c.group == "inside",
        Share(in_group),
        Some([0.90, 1.0]),
    ),
    measure("… or unexplained", |c| c.group == "inside", Share(right), None),
    measure(
        "unknown and inside: one set alone imitates it",
        has_imitations,
        Share(one_imitation),
        None,
    ),
    measure(
        "unknown and imitated by several sets: a group",
        |c| has_imitations(c) && !one_imitation(c),
        Share(in_group),
        None,
    ),
    measure("error of the strength", single, Median(|c| c.strength_error), Some([0.0, 0.05])),
    measure(
        "95 % intervals that hold the truth",
        |_| true,
        Counts(|c| [c.covered, c.intervals]),
        Some([0.93, 0.97]),
    ),
    measure(
        "held-out error over the noise floor",
        in_catalogue,
        Median(|c| c.after_m / c.floor_m),
        Some([0.0, MAX_RATIO_AT_FLOOR]),
    ),
    measure(
        "held-out error of at most 1.10 times the floor",
        in_catalogue,
        Share(|c| c.after_m <= MAX_RATIO_AT_FLOOR * c.floor_m),
        None,
    ),
    measure("gap closed", in_catalogue, Median(|c| gap_closed(c).unwrap_or(f64::NAN)), None),
    measure(
        "better than stiffness refitted (2 mm and more)",
        |c| beats_stiffness_about(c) && clearly_visible(c),
        Share(beats_stiffness),
        Some([1.0, 1.0]),
    ),
    measure(
        "better than stiffness refitted (any size)",
        beats_stiffness_about,
        Share(beats_stiffness),
        None,
    ),
    measure(
        "better than a GP (2 mm and more)",
        |c| has_gp(c) && clearly_visible(c),
        Share(beats_gp),
        Some([1.0, 1.0]),
    ),
    measure("better than a GP (any size)", has_gp, Share(beats_gp), None),
    measure("cases without an answer", |_| true, Share(|c| c.verdict.starts_with("failed")), None),
];

/// Every figure over all cases, then over each number of samples and each level of noise where
/// there are several. Figures that no case is about are left out.
pub(crate) fn summary(cases: &[CaseRow]) -> Vec<SummaryRow> {
    let samples = ascending(cases.iter().map(|case| case.samples as f64));
    let noises = ascending(cases.iter().map(|case| case.noise_m));
    let mut rows = part("all", cases.iter());
    if samples.len() > 1 {
        for count in samples.iter().rev() {
            let with_samples = cases.iter().filter(|case| case.samples as f64 == *count);
            rows.extend(part(&format!("{count} samples"), with_samples));
        }
    }
    if noises.len() > 1 {
        for noise_m in &noises {
            let with_noise = cases.iter().filter(|case| case.noise_m == *noise_m);
            rows.extend(part(&noise_name(*noise_m), with_noise));
        }
    }
    rows
}

/// A level of noise in words.
fn noise_name(noise_m: f64) -> String {
    // Nine digits are published; three are read.
    format!("noise {} mm", (1e6 * noise_m).round() / 1e3)
}

fn part<'a>(name: &str, cases: impl Iterator<Item = &'a CaseRow>) -> Vec<SummaryRow> {
    let cases: Vec<&CaseRow> = cases.collect();
    MEASURES.iter().filter_map(|measure| row(name, measure, &cases)).collect()
}

fn row(part: &str, measure: &Measure, cases: &[&CaseRow]) -> Option<SummaryRow> {
    let relevant: Vec<&CaseRow> =
        cases.iter().copied().filter(|case| (measure.about)(case)).collect();
    let (estimate, count, kind) = match measure.kind {
        Share(holds) => {
            let hits = relevant.iter().filter(|case| holds(case)).count() as u64;
            (wilson(hits, relevant.len() as u64)?, relevant.len() as u64, "share")
        }
        Counts(counts) => {
            let [hits, of] = relevant
                .iter()
                .map(|case| counts(case))
                .fold([0, 0], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
            (wilson(hits, of)?, of, "share")
        }
        Median(number) => {
            let values: Vec<f64> = relevant
                .iter()
                .map(|case| number(case))
                .filter(|value| value.is_finite())
                .collect();
            (median(&values)?, values.len() as u64, "median")
        }
    };
    let IntervalEstimate { value, low_95, high_95 } = estimate;
    let [goal_low, goal_high] = measure.goal.unwrap_or([f64::NAN; 2]);
    let met = if (goal_low..=goal_high).contains(&value) { "met" } else { "not met" };
    Some(SummaryRow {
        part: part.to_owned(),
        measure: measure.name.to_owned(),
        cases: count,
        value,
        low_95,
        high_95,
        kind: kind.to_owned(),
        goal: measure.goal.map_or_else(String::new, |goal| goal_words(measure.name, goal)),
        goal_low,
        goal_high,
        verdict: if measure.goal.is_some() { met.to_owned() } else { String::new() },
    })
}

/// Whether a figure is a ratio to the noise floor and not a share.
pub(crate) fn is_ratio(measure: &str) -> bool {
    measure.ends_with("over the noise floor")
}

fn goal_words(measure: &str, [low, high]: [f64; 2]) -> String {
    let number = |value: f64| {
        if is_ratio(measure) { format!("{value:.2}") } else { format!("{:.0} %", 100.0 * value) }
    };
    match [low, high] {
        [1.0, 1.0] => "always".to_owned(),
        [0.0, high] => format!("≤ {}", number(high)),
        [low, 1.0] => format!("≥ {}", number(low)),
        [low, high] => format!("{:.0}–{}", 100.0 * low, number(high)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_goals_read_well() {
        for (index, one) in MEASURES.iter().enumerate() {
            assert!(MEASURES[..index].iter().all(|other| other.name != one.name), "{}", one.name);
        }
        assert_eq!(goal_words("a", [0.95, 1.0]), "≥ 95 %");
        assert_eq!(goal_words("a", [0.0, 0.01]), "≤ 1 %");
        assert_eq!(goal_words("a", [0.93, 0.97]), "93–97 %");
        assert_eq!(goal_words("error over the noise floor", [0.0, 1.1]), "≤ 1.10");
        assert_eq!(goal_words("a", [1.0, 1.0]), "always");
    }
}
