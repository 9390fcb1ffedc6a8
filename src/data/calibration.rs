//! What a calibration found (`calibration.json`) and the rows of the tables behind it.

use serde::{Deserialize, Serialize};

/// A fitted number (`numbers.csv`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CalibratedNumber {
    /// Its path in the model file, or its short name.
    pub name: String,
    /// Its unit; `1` for a plain ratio.
    pub unit: String,
    /// Value before the fit.
    pub start: f64,
    /// Best value.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Standard deviation of its prior; empty without one.
    pub prior_deviation: Option<f64>,
    /// Whether the recording determines it.
    pub determined: bool,
}

/// Two numbers that the data tell apart badly (`trade_offs.csv`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TradeOff {
    /// A number.
    pub first: String,
    /// Another one.
    pub second: String,
    /// Correlation of their errors.
    pub correlation: f64,
}

/// Error of one model on positions that its fit has not seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelError {
    /// The model.
    pub name: String,
    /// Numbers fitted; 0 where none were or where they are no measure (Gaussian process).
    pub numbers: usize,
    /// Root mean square distance, metres.
    pub rms_m: f64,
    /// The same after the mean error of each tracked point is taken off, metres.
    pub rms_without_mean_m: f64,
    /// Root mean square distance of each tracked point, metres.
    pub by_point_m: Vec<f64>,
    /// Hyper-parameters that ended at an end of their range, and in how many of its fits: one fit
    /// an axis, a tracked point and a part held out.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub at_range_end: String,
}

/// Errors on what the fits have not seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOutError {
    /// How it was held out.
    pub how: String,
    /// Patterns or trials that were held out for good.
    pub names: Vec<String>,
    /// Number of positions.
    pub positions: usize,
    /// Names of the tracked points.
    pub points: Vec<String>,
    /// The calibrated model first, then the others.
    pub models: Vec<ModelError>,
}

/// Error of a group of positions (`residual_groups.csv`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResidualGroup {
    /// What the group is: `point`, `recording`, `pattern`, `trial`, `block`, `stretch of time` or
    /// `place`.
    pub kind: String,
    /// Which.
    pub name: String,
    /// Number of positions.
    pub positions: usize,
    /// Root mean square distance, metres.
    pub rms_m: f64,
    /// Mean of simulated minus measured, metres.
    pub mean_x_m: f64,
    /// Mean of simulated minus measured, metres.
    pub mean_y_m: f64,
    /// Mean of simulated minus measured, metres.
    pub mean_z_m: f64,
}

/// One measured position and its error (`residuals.csv`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SightingRow {
    /// Trial.
    pub trial: u64,
    /// Time in the trial, s.
    pub time_s: f64,
    /// Pattern, trial or stretch of time by which rows are held out together, after the recording
    /// where there are several.
    pub block: String,
    /// Tracked point.
    pub point: String,
    /// Measured, metres.
    pub x_m: f64,
    /// Measured, metres.
    pub y_m: f64,
    /// Measured, metres.
    pub z_m: f64,
    /// Simulated minus measured, metres.
    pub error_x_m: f64,
    /// Simulated minus measured, metres.
    pub error_y_m: f64,
    /// Simulated minus measured, metres.
    pub error_z_m: f64,
    /// Weight in the fit: below 1 for outliers.
    pub weight: f64,
}

/// Noise of the measurement, and what the model leaves beyond it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseAndMisfit {
    /// Root mean square distance by noise alone, metres.
    pub noise_m: f64,
    /// Where that is from.
    pub from: String,
    /// Pairs of rows behind it.
    pub pairs: usize,
    /// Error of the model over that of noise.
    pub ratio: f64,
    /// Whether noise alone does not explain the error.
    pub beyond_noise: bool,
}

/// A stage of `--fit auto` or `--select` (`stages.csv`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitStage {
    /// What it adds.
    pub name: String,
    /// Numbers with it.
    pub numbers: usize,
    /// Cross-validated error with it, metres.
    pub cross_validated_m: f64,
    /// Whether it was kept.
    pub kept: bool,
}

/// `calibration.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CalibrationFindings {
    /// The fitted numbers.
    pub numbers: Vec<CalibratedNumber>,
    /// Numbers that trade against each other, most first.
    pub trade_offs: Vec<TradeOff>,
    /// Compared rows.
    pub rows: usize,
    /// Compared positions: tracked points in rows.
    pub positions: usize,
    /// Rows that the calibrated model could not solve.
    pub unsolved: usize,
    /// Root mean square distance before the fit, metres.
    pub before_m: f64,
    /// The same after it.
    pub after_m: f64,
    /// Noise and misfit, as far as the recording tells them.
    pub noise: Option<NoiseAndMisfit>,
    /// Distribution of the errors in the fit: `normal` or `student_t`.
    pub likelihood: String,
    /// Number of positions too far from the model to belong to the same noise.
    pub outliers: usize,
    /// Errors on what the fit has not seen.
    pub held_out: Option<HeldOutError>,
    /// Errors by point, pattern and place.
    pub residual_groups: Vec<ResidualGroup>,
    /// Stages, where numbers were selected.
    pub stages: Vec<FitStage>,
    /// What a user must know about the result.
    pub limitations: Vec<String>,
}
