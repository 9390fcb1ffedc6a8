//! What blind cases are made: their groups, sizes and the truth behind them.

use serde::{Deserialize, Serialize};

use crate::base::BadOption;
use crate::effects::Robot;
use crate::rod::Resolution;

/// What is hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CaseGroup {
    /// Nothing but noise and the uncertainty of the model's numbers.
    Nothing,
    /// One effect of the catalogue.
    Single,
    /// Two effects of the catalogue.
    Pair,
    /// What no few effects of the catalogue imitate: a disturbance that is in no catalogue, or an effect taken out of it.
    Outside,
    /// An effect taken out of the catalogue that a few others imitate.
    Inside,
}

impl CaseGroup {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            CaseGroup::Nothing => "nothing",
            CaseGroup::Single => "single",
            CaseGroup::Pair => "pair",
            CaseGroup::Outside => "outside",
            CaseGroup::Inside => "inside",
        }
    }

    /// Whether its cases need the oracle.
    pub fn judged(self) -> bool {
        matches!(self, CaseGroup::Outside | CaseGroup::Inside)
    }
}

/// Cases of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaseBatch {
    /// What is hidden in them.
    pub group: CaseGroup,
    /// How many.
    pub cases: usize,
    /// Trials of a recording, each from rest at home.
    #[serde(default = "trials")]
    pub trials: usize,
    /// Samples of a recording, over all trials.
    #[serde(default = "samples")]
    pub samples: usize,
    /// How far what is hidden is to move the tip, root mean square, metres; cases take them in turn.
    #[serde(default = "shifts_m")]
    pub shifts_m: Vec<f64>,
    /// Standard deviation of the noise an axis, metres.
    #[serde(default = "noise_m")]
    pub noise_m: f64,
    /// Correlation of the noise from one sample to the next; cases take them in turn.
    #[serde(default = "correlations")]
    pub correlations: Vec<f64>,
}

fn trials() -> usize {
    8
}
fn samples() -> usize {
    400
}
fn shifts_m() -> Vec<f64> {
    vec![0.004]
}
fn noise_m() -> f64 {
    5e-4
}
fn correlations() -> Vec<f64> {
    vec![0.0]
}

/// More cases in a batch would fill the memory with plans before anything runs.
const MOST_CASES: usize = 100_000;
/// Samples of a recording beyond this are a wrong number.
const MOST_SAMPLES: usize = 100_000;
/// Shifts and noise beyond this are a wrong unit, metres.
const MOST_M: f64 = 0.05;

impl CaseBatch {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        let counted = |key, value: usize, least: usize, most: usize, expected| {
            let good = (least..=most).contains(&value);
            if good { Ok(()) } else { Err(BadOption { key, found: value.to_string(), expected }) }
        };
        counted("cases", self.cases, 1, MOST_CASES, "1 to 100000")?;
        counted("trials", self.trials, 2, self.samples / 2, "at least 2, and 2 samples in each")?;
        counted("samples", self.samples, 30, MOST_SAMPLES, "30 to 100000")?;
        let within = |key, value: f64, expected| {
            let good = value > 0.0 && value <= MOST_M;
            if good { Ok(()) } else { Err(BadOption { key, found: value.to_string(), expected }) }
        };
        within("noise_m", self.noise_m, "above 0 and up to 0.05 m")?;
        let some = |key, empty: bool| {
            let found = "an empty list".to_owned();
            if empty { Err(BadOption { key, found, expected: "at least one value" }) } else { Ok(()) }
        };
        some("shifts_m", self.shifts_m.is_empty())?;
        self.shifts_m.iter().try_for_each(|&shift| within("shifts_m", shift, "above 0 and up to 0.05 m"))?;
        some("correlations", self.correlations.is_empty())?;
        self.correlations.iter().try_for_each(|&correlation| {
            let good = (0.0..1.0).contains(&correlation);
            let found = correlation.to_string();
            if good { Ok(()) } else { Err(BadOption { key: "correlations", found, expected: "0 to below 1" }) }
        })
    }
}

/// How finely the truth is computed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TruthOptions {
    /// Largest length of an integration cell, metres.
    pub cell_m: f64,
    /// Polynomials for each bending moment.
    pub bending_modes: usize,
    /// Largest time step, s.
    pub time_step_s: f64,
    /// Error that a time step may add to the position of any part of the rod, metres.
    pub motion_tolerance_m: f64,
    /// Whether every other case follows another law of the same name, where there is one.
    pub other_laws: bool,
}

impl Default for TruthOptions {
    fn default() -> Self {
        // With steps of 1e-5 m dry friction is off by 0.08 mm, more than what the answer's fit is off by.
        TruthOptions { cell_m: 0.008, bending_modes: 8, time_step_s: 0.05, motion_tolerance_m: 1e-6, other_laws: true }
    }
}

impl TruthOptions {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("cell_m", self.cell_m)?;
        BadOption::unless_positive("time_step_s", self.time_step_s)?;
        BadOption::unless_positive("motion_tolerance_m", self.motion_tolerance_m)?;
        let robot = Robot { resolution: self.resolution(&Resolution::default()), ..Robot::default() };
        robot.check().map_err(|(_, error)| error)
    }

    /// The resolution of the true robot, where the model has `model`'s.
    pub(crate) fn resolution(&self, model: &Resolution) -> Resolution {
        Resolution {
            cell_m: self.cell_m,
            bending_modes: self.bending_modes,
            time_step_s: self.time_step_s,
            motion_tolerance_m: self.motion_tolerance_m,
            ..*model
        }
    }
}

/// When something is outside the span of the catalogue, and when inside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OracleOptions {
    /// Outside: the best few others leave more than this, over the noise.
    pub outside_above: f64,
    /// Inside: they leave less than this.
    pub inside_below: f64,
    /// Others that are taken together at most, 1 to 3.
    pub most_effects: usize,
    /// Cases that share one set of commands, and with it the answers of the model that the oracle needs.
    pub cases_per_commands: usize,
}

impl Default for OracleOptions {
    fn default() -> Self {
        OracleOptions { outside_above: 0.6, inside_below: 0.2, most_effects: 3, cases_per_commands: 10 }
    }
}

impl OracleOptions {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("inside_below", self.inside_below)?;
        if !(self.outside_above.is_finite() && self.outside_above >= self.inside_below) {
            let found = self.outside_above.to_string();
            return Err(BadOption { key: "outside_above", found, expected: "at least inside_below" });
        }
        if !(1..=3).contains(&self.most_effects) {
            let found = self.most_effects.to_string();
            return Err(BadOption { key: "most_effects", found, expected: "1 to 3" });
        }
        BadOption::unless_counted("cases_per_commands", self.cases_per_commands)
    }
}

/// A number that a lab knows only so well: normally distributed about the value at which the effect changes nothing, all
/// components of a vector and all tendons each for itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Prior {
    /// The effect whose parameter it is.
    pub effect: String,
    /// The parameter.
    pub parameter: String,
    /// Standard deviation, in the parameter's unit.
    pub deviation: f64,
}
