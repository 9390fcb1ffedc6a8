//! What a discovery found: the answer (`findings.json`) and the rows of the tables behind it.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::table_row::table_rows;
use super::{DataError, write_atomic};

/// The answer in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The effects explain the gap, and nothing else in the catalogue does.
    Named,
    /// No more than noise and the model's own uncertainty.
    Consistent,
    /// Several candidates fit equally well.
    Ambiguous,
    /// The model error exceeds the noise, and nothing in the catalogue closes it.
    Unexplained,
}

impl Verdict {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Named => "named",
            Verdict::Consistent => "consistent",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Unexplained => "unexplained",
        }
    }
}

/// An effect of the answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FoundEffect {
    /// Its name in the catalogue.
    pub name: String,
    /// Its parameters as in a model file: numbers, or lists of numbers.
    pub parameters: BTreeMap<String, Value>,
    /// For each fitted parameter its 95 % interval `[low, high]`; a list of them for a vector.
    pub interval_95: BTreeMap<String, Value>,
    /// Probability that the answer holds it, among the candidates that were fitted.
    pub confidence: f64,
    /// Effects that could stand in its place as far as these data tell.
    pub confusable_with: Vec<String>,
}

/// How far model and measurement are apart on trials that took no part in naming or fitting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// What is measured.
    pub metric: String,
    /// Numbers of the trials.
    pub held_out_trials: Vec<u64>,
    /// Without the effects, metres.
    pub before_m: f64,
    /// With them, metres.
    pub after_m: f64,
}

/// A place where they disagree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Disagreement {
    /// The place in words.
    #[serde(rename = "where")]
    pub place: String,
    /// `x`, `y`, `z` or `all`.
    pub axis: String,
    /// Root mean square residual there, metres.
    pub rms_m: f64,
    /// Its part of the whole sum of squares.
    pub share: f64,
    /// Probability of as much by noise alone, corrected for the number of places looked at.
    pub p_value: f64,
}

/// A candidate and why it is not the answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its effects, joined by ` + `.
    pub name: String,
    /// Penalised log-likelihood ratio to the model as given, in units of 2 ln: more is better.
    pub score: f64,
    /// Root mean square tip error with it on trials that its fit has not seen, metres.
    pub after_m: f64,
    /// Why it is not the answer; empty for the answer.
    pub why_not: String,
}

/// A test whether anything is missing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissingTest {
    /// Root mean square residual, metres.
    pub rms_m: f64,
    /// The part of it that other trials foretell, metres.
    pub foretold_m: f64,
    /// Probability of as much by noise alone.
    pub p_value: f64,
}

/// What noise there is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Standard deviation along x, y and z, metres.
    pub sigma_m: [f64; 3],
    /// Correlation from one sample to the next.
    pub correlation: f64,
    /// From what it was estimated.
    pub from: String,
}

/// Something to record next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// Its name in the menu.
    pub name: String,
    /// What to do, in a sentence.
    pub what: String,
    /// How long it takes, set-up included, minutes.
    pub minutes: f64,
    /// Distance between the rivals' predictions, in standard deviations of the noise, refitted: the least of all pairs.
    pub separation: f64,
    /// File with the commands.
    pub file: String,
}

/// `findings.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// The answer in a word.
    pub verdict: Verdict,
    /// The effects named, or for `ambiguous` those between which the data cannot tell.
    pub effects: Vec<FoundEffect>,
    /// Root mean square distance of the tip from the truth that noise alone makes, metres.
    pub noise_floor_m: f64,
    /// Held-out gap before and after.
    pub gap: Gap,
    /// Where they disagree, the largest first.
    pub disagreement: Vec<Disagreement>,
    /// The candidates, the best first.
    pub candidates: Vec<Candidate>,
    /// What to record next, in words.
    pub next_measurement: String,
    /// The answer in a sentence or two.
    pub summary: String,
    /// The noise.
    pub noise: Noise,
    /// Is anything missing from the model as given?
    pub missing_before: MissingTest,
    /// Is anything still missing from the model with the effects?
    pub missing_after: MissingTest,
    /// For `unexplained`: what the rest looks like.
    pub pattern: String,
    /// What these data could not show, and what was left out of them.
    pub limitations: Vec<String>,
    /// What could be recorded next, the best first.
    pub proposals: Vec<Proposal>,
}

impl Findings {
    /// Writes `findings.json`, whole or not at all.
    ///
    /// # Errors
    /// [`DataError::Write`] when the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), DataError> {
        let refused = |reason: String| DataError::Write { file: path.to_owned(), reason };
        let mut text = serde_json::to_string_pretty(self).map_err(|error| refused(error.to_string()))?;
        text.push('\n');
        write_atomic(path, text.as_bytes())
    }
}

/// A sample: where the tip was and how far off the model is (`residuals.csv`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResidualRow {
    /// Trial.
    pub trial: u64,
    /// Time since it began, seconds.
    pub time_s: f64,
    /// Whether the trial took no part in naming or fitting.
    pub held_out: bool,
    /// Measured tip, metres.
    pub tip_x_m: f64,
    /// Measured tip, metres.
    pub tip_y_m: f64,
    /// Measured tip, metres.
    pub tip_z_m: f64,
    /// Measured minus the model as given, metres.
    pub before_x_m: f64,
    /// Measured minus the model as given, metres.
    pub before_y_m: f64,
    /// Measured minus the model as given, metres.
    pub before_z_m: f64,
    /// Measured minus the model with the effects, metres.
    pub after_x_m: f64,
    /// Measured minus the model with the effects, metres.
    pub after_y_m: f64,
    /// Measured minus the model with the effects, metres.
    pub after_z_m: f64,
}

/// A place of the map of disagreement (`disagreement.csv`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaceRow {
    /// What the samples were sorted by: `workspace`, `time in trial`, `direction of motion`, `tension`, `history`, `all`.
    pub by: String,
    /// The place, such as `x above 0.05 m` or `first third`.
    pub place: String,
    /// `x`, `y`, `z` or `all`.
    pub axis: String,
    /// Samples there.
    pub samples: u64,
    /// Mean residual of the model as given, metres; empty for axis `all`.
    pub mean_before_m: f64,
    /// Root mean square residual of the model as given, metres.
    pub rms_before_m: f64,
    /// Probability of as much by noise alone, corrected for the number of places.
    pub p_before: f64,
    /// Mean residual of the model with the effects, metres.
    pub mean_after_m: f64,
    /// Root mean square residual of the model with the effects, metres.
    pub rms_after_m: f64,
    /// Probability of as much by noise alone, corrected for the number of places.
    pub p_after: f64,
    /// What noise alone would give, metres.
    pub floor_m: f64,
}

/// Between sets of effects in one cell.
pub const OR: &str = " or ";

table_rows! {
    "discovery.csv", key [case]:
    /// One blind case and the answer to it (`discovery.csv` of the benchmark).
    pub struct CaseRow {
        /// Number of the case.
        pub case: u64,
        /// What was hidden: `nothing`, `single`, `pair`, `outside` (unknown, outside the span of the catalogue) or
        /// `inside` it.
        pub group: String,
        /// Hidden effects joined by ` + `; empty for nothing.
        pub truth: String,
        /// How far the hidden effects move the tip, root mean square, metres.
        pub shift_m: f64,
        /// Standard deviation of the noise an axis, metres.
        pub noise_m: f64,
        /// Its correlation from one sample to the next.
        pub correlation: f64,
        /// Samples in the recording.
        pub samples: u64,
        /// The verdict, or `failed: …`.
        pub verdict: String,
        /// Effects named, or for `ambiguous` the group, joined by ` + `.
        pub answer: String,
        /// Named exactly right (for nothing: consistent; for outside: unexplained; for inside: ambiguous or unexplained).
        pub right: bool,
        /// The truth is the answer, or the answer is a group that holds it (inside: a group, as the truth is not on
        /// offer).
        pub in_group: bool,
        /// Inside the span: the smallest sets of others that imitate what is hidden equally well, by the oracle,
        /// joined by ` or `; empty in older tables.
        #[serde(default)]
        pub imitations: String,
        /// Of right answers: length of the difference over length of the size, of the size parameters; the median
        /// over a pair.
        pub strength_error: f64,
        /// Parameters with an interval.
        pub intervals: u64,
        /// Intervals that hold the true value.
        pub covered: u64,
        /// Held-out rms tip error of the model as given, metres.
        pub before_m: f64,
        /// With the effects, metres.
        pub after_m: f64,
        /// With a refit of stiffness alone, metres.
        pub stiffness_only_m: f64,
        /// With the paper's Gaussian process on the residual, metres.
        pub gp_m: f64,
        /// Noise floor that was estimated, metres.
        pub floor_m: f64,
    }

    "intervals.csv", key [case, effect, parameter]:
    /// A 95 % interval of a rightly named effect beside the truth (`intervals.csv` of the benchmark).
    pub struct IntervalRow {
        /// Number of the case.
        pub case: u64,
        /// Samples in the recording.
        pub samples: u64,
        /// The effect.
        pub effect: String,
        /// Its parameter, in whose unit the numbers are; a component of a vector as `name[k]`.
        pub parameter: String,
        /// The true value.
        pub truth: f64,
        /// The answer.
        pub value: f64,
        /// Lower end of the interval.
        pub low: f64,
        /// Upper end.
        pub high: f64,
        /// Whether it holds the truth.
        pub covered: bool,
    }
}
