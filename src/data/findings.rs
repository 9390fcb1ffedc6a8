//! Findings of a discovery (`findings.json`) and the rows of the tables behind them.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::DataError;
use super::table_rows;

/// Verdict of a discovery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The effects explain the model error, and no other candidate does.
    Named,
    /// No more than noise and model uncertainty.
    Consistent,
    /// Several candidates fit equally well.
    Ambiguous,
    /// The model error exceeds the noise, and no effect of the catalogue explains it.
    Unexplained,
}

impl Verdict {
    /// Name in files.
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
    /// Name in the catalogue.
    pub name: String,
    /// Parameters as in a model file: numbers, or lists of numbers.
    pub parameters: BTreeMap<String, Value>,
    /// For each fitted parameter its 95 % interval `[low, high]`; a list of them for a vector.
    pub interval_95: BTreeMap<String, Value>,
    /// Posterior probability among the fitted candidates.
    pub confidence: f64,
    /// Effects that could replace it as far as these data tell.
    pub confusable_with: Vec<String>,
}

/// Model error on held-out trials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Definition of the error.
    pub metric: String,
    /// Numbers of the held-out trials.
    pub held_out_trials: Vec<u64>,
    /// Without the effects, metres.
    pub before_m: f64,
    /// With them, metres.
    pub after_m: f64,
}

/// Residual of one group of samples along one axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Disagreement {
    /// The group, as text.
    #[serde(rename = "where")]
    pub place: String,
    /// `x`, `y`, `z` or `all`.
    pub axis: String,
    /// Root mean square residual, metres.
    pub rms_m: f64,
    /// Share of the total sum of squares.
    pub share: f64,
    /// Probability of this or more from noise alone, corrected for the number of groups.
    pub p_value: f64,
}

/// A candidate, and why it is not the answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its effects, joined by ` + `.
    pub name: String,
    /// Penalised log-likelihood ratio to the given model, in units of 2 ln; larger is better.
    pub score: f64,
    /// Leave-one-trial-out rms tip error, metres.
    pub after_m: f64,
    /// Why it is not the answer; empty for the answer.
    pub why_not: String,
    /// Its fitted parameters, `effect.parameter=value`, joined by `; `; empty if it was not fitted.
    pub parameters: String,
}

/// Result of the cross-trial test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissingTest {
    /// Root mean square residual, metres.
    pub rms_m: f64,
    /// Part that other trials predict, metres.
    pub foretold_m: f64,
    /// Probability of this or more from noise alone.
    pub p_value: f64,
}

/// Measurement noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Standard deviation along x, y and z, metres.
    pub sigma_m: [f64; 3],
    /// Correlation of consecutive samples.
    pub correlation: f64,
    /// Sources of the estimate.
    pub from: String,
}

/// A row of the recording that was left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExcludedRow {
    /// Trial.
    pub trial: u64,
    /// Time in the trial, seconds.
    pub time_s: f64,
    /// Why, as text.
    pub why: String,
}

/// A proposed measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// Name of the protocol.
    pub name: String,
    /// Instruction in one sentence.
    pub what: String,
    /// Duration including set-up, minutes.
    pub minutes: f64,
    /// Smallest distance between predictions of two rivals after refitting, in standard deviations
    /// of the noise.
    pub separation: f64,
    /// File with the commands.
    pub file: String,
}

/// `findings.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// The verdict.
    pub verdict: Verdict,
    /// The named effects; for `ambiguous` those that the data cannot tell apart.
    pub effects: Vec<FoundEffect>,
    /// Rms distance of the measured from the true tip by noise alone, metres.
    pub noise_floor_m: f64,
    /// Share of the held-out squares, beyond what the model leaves on this robot anyway, that the
    /// named effects explain; none where nothing is named.
    pub explained_share: Option<f64>,
    /// Its 95 % interval.
    pub explained_share_interval_95: Option<[f64; 2]>,
    /// Rms tip error on held-out trials beyond what the model leaves on this robot anyway, metres.
    pub left_m: f64,
    /// Whether nothing significant is left.
    pub complete: bool,
    /// What the model leaves on this robot beyond noise although nothing is missing, rms, metres.
    pub model_form_m: f64,
    /// Held-out error before and after.
    pub gap: Gap,
    /// Residual by group, largest over noise first.
    pub disagreement: Vec<Disagreement>,
    /// Candidates, best first.
    pub candidates: Vec<Candidate>,
    /// What to record next.
    pub next_measurement: String,
    /// Summary in one or two sentences.
    pub summary: String,
    /// Measurement noise.
    pub noise: Noise,
    /// Cross-trial test of the given model.
    pub missing_before: MissingTest,
    /// Cross-trial test of the model with the effects.
    pub missing_after: MissingTest,
    /// For `unexplained`: pattern of the residual.
    pub pattern: String,
    /// Limitations of the data and excluded samples.
    pub limitations: Vec<String>,
    /// Rows that were left out of fit, noise and held-out error, in the order of the recording.
    #[serde(default)]
    pub excluded_rows: Vec<ExcludedRow>,
    /// Offset of the tracker's clock from that of the commands, seconds, positive when it is ahead;
    /// none where none was found.
    #[serde(default)]
    pub clock_offset_s: Option<f64>,
    /// Its 95 % interval, seconds.
    #[serde(default)]
    pub clock_offset_interval_95: Option<[f64; 2]>,
    /// Proposed measurements, best first.
    pub proposals: Vec<Proposal>,
}

impl Findings {
    /// The text of `findings.json`.
    ///
    /// # Errors
    /// [`DataError::Write`] with the name `path` if a number cannot be written.
    pub fn to_json(&self, path: &Path) -> Result<Vec<u8>, DataError> {
        let refused = |error: serde_json::Error| DataError::Write {
            file: path.to_owned(),
            reason: error.to_string(),
        };
        let mut text = serde_json::to_string_pretty(self).map_err(refused)?;
        text.push('\n');
        Ok(text.into_bytes())
    }
}

/// One sample with its residuals (`residuals.csv`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResidualRow {
    /// Trial.
    pub trial: u64,
    /// Time in the trial, seconds.
    pub time_s: f64,
    /// Whether the trial is held out.
    pub held_out: bool,
    /// Name of the tracked point; empty for the tip.
    #[serde(default)]
    pub point: String,
    /// Measured tip or point, metres.
    pub tip_x_m: f64,
    /// Measured tip or point, metres.
    pub tip_y_m: f64,
    /// Measured tip or point, metres.
    pub tip_z_m: f64,
    /// Measured minus given model, metres.
    pub before_x_m: f64,
    /// Measured minus given model, metres.
    pub before_y_m: f64,
    /// Measured minus given model, metres.
    pub before_z_m: f64,
    /// Measured minus model with the effects, metres.
    pub after_x_m: f64,
    /// Measured minus model with the effects, metres.
    pub after_y_m: f64,
    /// Measured minus model with the effects, metres.
    pub after_z_m: f64,
}

impl ResidualRow {
    /// Measured minus given model, metres.
    pub fn before_m(&self) -> [f64; 3] {
        [self.before_x_m, self.before_y_m, self.before_z_m]
    }

    /// Measured minus model with the effects, metres.
    pub fn after_m(&self) -> [f64; 3] {
        [self.after_x_m, self.after_y_m, self.after_z_m]
    }
}

/// One group of samples of the residual map along one axis (`disagreement.csv`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaceRow {
    /// Grouping: `workspace`, `time in trial`, `direction of motion`, `largest pull`, `history`,
    /// `all`.
    pub by: String,
    /// The group, such as `x above 50 mm` or `first third`.
    pub place: String,
    /// `x`, `y`, `z` or `all`.
    pub axis: String,
    /// Number of samples.
    pub samples: u64,
    /// Mean residual of the given model, metres; empty for axis `all`.
    pub mean_before_m: f64,
    /// Rms residual of the given model, metres.
    pub rms_before_m: f64,
    /// Probability of this or more from noise alone, corrected for the number of groups.
    pub p_before: f64,
    /// Mean residual of the model with the effects, metres.
    pub mean_after_m: f64,
    /// Rms residual of the model with the effects, metres.
    pub rms_after_m: f64,
    /// Probability of this or more from noise alone, corrected for the number of groups.
    pub p_after: f64,
    /// Rms by noise alone, metres.
    pub floor_m: f64,
}

/// A number that older tables do not have.
fn missing() -> f64 {
    f64::NAN
}

/// Separator of sets of effects in one cell.
pub const OR: &str = " or ";

table_rows! {
    "discovery.csv", key [case], failed [|row| row.verdict.starts_with("failed")]:
    /// One blind case and the answer to it (`discovery.csv` of the benchmark).
    pub struct CaseRow {
        /// Number of the case.
        pub case: u64,
        /// Hidden effects: `nothing`, `single`, `pair`, `outside` (unknown, outside the span of the
        /// catalogue) or `inside` it.
        pub group: String,
        /// Hidden effects joined by ` + `; empty for nothing.
        pub truth: String,
        /// Root mean square displacement of the tip by the hidden effects, metres.
        pub shift_m: f64,
        /// Standard deviation of the noise per axis, metres.
        pub noise_m: f64,
        /// Its correlation from one sample to the next.
        pub correlation: f64,
        /// Samples in the recording.
        pub samples: u64,
        /// The verdict, or `failed: …`.
        pub verdict: String,
        /// Effects named, or for `ambiguous` the group, joined by ` + `.
        pub answer: String,
        /// Named exactly right (for nothing: consistent; for outside: unexplained; for inside:
        /// ambiguous or unexplained).
        pub right: bool,
        /// The answer is the truth or a group that contains it (inside: a group, because the truth
        /// is not in the catalogue).
        pub in_group: bool,
        /// Inside the span: the smallest sets of other effects that imitate the hidden effect
        /// equally well according to the oracle, joined by ` or `; empty in older tables.
        #[serde(default)]
        pub imitations: String,
        /// Of right answers: length of the difference over length of the size, of the size
        /// parameters; the median over a pair.
        pub strength_error: f64,
        /// Parameters with an interval.
        pub intervals: u64,
        /// Intervals that contain the true value.
        pub covered: u64,
        /// Held-out rms tip error of the model as given, metres.
        pub before_m: f64,
        /// With the effects, metres.
        pub after_m: f64,
        /// With a refit of stiffness alone, metres.
        pub stiffness_only_m: f64,
        /// With the paper's Gaussian process on the residual, metres.
        pub gp_m: f64,
        /// Estimated noise floor, metres.
        pub floor_m: f64,
        /// Probability of the hidden effects in the answer (1 − total variation distance from equal
        /// probabilities of them); empty where they are not in the catalogue.
        #[serde(default = "missing")]
        pub isolation: f64,
        /// Effects selected by sparse regression on the responses to the catalogue, joined by ` +
        /// `; empty for none.
        #[serde(default)]
        pub sparse_answer: String,
        /// Probability of the hidden effects in its answer.
        #[serde(default = "missing")]
        pub sparse_isolation: f64,
        /// Held-out rms tip error with it, metres; empty in older tables.
        #[serde(default = "missing")]
        pub sparse_m: f64,
        /// Whether ridge regression on all effects predicts unseen trials.
        #[serde(default)]
        pub ridge_detects: bool,
        /// Probability of the hidden effects in their answer.
        #[serde(default = "missing")]
        pub ridge_isolation: f64,
        /// Held-out rms tip error with them, metres; empty in older tables.
        #[serde(default = "missing")]
        pub ridge_m: f64,
        /// Whether sparse regression on polynomials and trigonometric functions predicts unseen
        /// trials.
        #[serde(default)]
        pub library_detects: bool,
        /// Held-out rms tip error with it, metres; empty in older tables.
        #[serde(default = "missing")]
        pub library_m: f64,
        /// Whether the Gaussian process predicts unseen trials.
        #[serde(default)]
        pub gp_detects: bool,
    }

    "intervals.csv", key [case, effect, parameter]:
    /// A 95 % interval of a rightly named effect beside the truth (`intervals.csv` of the
    /// benchmark).
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
