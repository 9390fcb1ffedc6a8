//! Options of the blind benchmark: groups of cases, sizes, and resolution of the truth.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::base::BadOption;
use crate::effects::Robot;
use crate::rod::Resolution;

/// Group of a case: what is injected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CaseGroup {
    /// Only noise and parameter uncertainty.
    Nothing,
    /// One effect of the catalogue.
    Single,
    /// Two effects of the catalogue.
    Pair,
    /// A gap that no small set of effects imitates: a disturbance outside the catalogue, or an
    /// effect removed from it.
    Outside,
    /// An effect removed from the catalogue that a small set of others imitates.
    Inside,
}

impl CaseGroup {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            CaseGroup::Nothing => "nothing",
            CaseGroup::Single => "single",
            CaseGroup::Pair => "pair",
            CaseGroup::Outside => "outside",
            CaseGroup::Inside => "inside",
        }
    }

    /// Whether the oracle must classify its cases.
    pub fn judged(self) -> bool {
        matches!(self, CaseGroup::Outside | CaseGroup::Inside)
    }
}

/// Cases of one group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaseBatch {
    /// What is injected.
    pub group: CaseGroup,
    /// Number of cases.
    pub cases: usize,
    /// Trials of a recording, each from rest at home.
    #[serde(default = "trials")]
    pub trials: usize,
    /// Samples of a recording, over all trials.
    #[serde(default = "samples")]
    pub samples: usize,
    /// Rms tip displacements by the injected effect, metres; used in turn.
    #[serde(default = "shifts_m")]
    pub shifts_m: Vec<f64>,
    /// Standard deviation of the noise by axis, metres.
    #[serde(default = "noise_m")]
    pub noise_m: f64,
    /// Correlations of consecutive noise samples; used in turn.
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

/// Maximum number of cases: their plan must fit in memory.
const MAX_CASES: usize = 100_000;
/// Maximum number of samples.
const MAX_SAMPLES: usize = 100_000;
/// Maximum displacement and noise, metres; larger values indicate a wrong unit.
const MAX_LENGTH_M: f64 = 0.05;

impl CaseBatch {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        let counted = |key, value: usize, range: RangeInclusive<usize>, expected| {
            if range.contains(&value) {
                Ok(())
            } else {
                Err(BadOption { key, found: value.to_string(), expected })
            }
        };
        counted("cases", self.cases, 1..=MAX_CASES, "1 to 100000")?;
        counted("trials", self.trials, 2..=self.samples / 2, "at least 2, and 2 samples in each")?;
        counted("samples", self.samples, 30..=MAX_SAMPLES, "30 to 100000")?;
        let within = |key, value: f64, expected| {
            let good = value > 0.0 && value <= MAX_LENGTH_M;
            if good { Ok(()) } else { Err(BadOption { key, found: value.to_string(), expected }) }
        };
        within("noise_m", self.noise_m, "above 0 and up to 0.05 m")?;
        let some = |key, empty: bool| {
            let found = "an empty list".to_owned();
            if empty {
                Err(BadOption { key, found, expected: "at least one value" })
            } else {
                Ok(())
            }
        };
        some("shifts_m", self.shifts_m.is_empty())?;
        self.shifts_m
            .iter()
            .try_for_each(|&shift| within("shifts_m", shift, "above 0 and up to 0.05 m"))?;
        some("correlations", self.correlations.is_empty())?;
        self.correlations.iter().try_for_each(|&correlation| {
            let good = (0.0..1.0).contains(&correlation);
            let found = correlation.to_string();
            if good {
                Ok(())
            } else {
                Err(BadOption { key: "correlations", found, expected: "0 to below 1" })
            }
        })
    }
}

/// Resolution of the truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TruthOptions {
    /// Largest length of an integration cell, metres.
    pub cell_m: f64,
    /// Number of modes of each bending moment.
    pub bending_modes: usize,
    /// Largest time step, seconds.
    pub time_step_s: f64,
    /// Error tolerance of a time step for the position of any part of the rod, metres.
    pub motion_tolerance_m: f64,
    /// Whether every other case follows another law of the same effect, if there is one.
    pub other_laws: bool,
}

impl Default for TruthOptions {
    fn default() -> Self {
        // At 1e-5 m the error of dry friction is 0.08 mm, more than the error of the answer's fit.
        TruthOptions {
            cell_m: 0.008,
            bending_modes: 8,
            time_step_s: 0.05,
            motion_tolerance_m: 1e-6,
            other_laws: true,
        }
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
        let robot =
            Robot { resolution: self.resolution(&Resolution::default()), ..Robot::default() };
        robot.check().map_err(|(_, error)| error)
    }

    /// Resolution of the true robot; other settings as in `model`.
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

/// Thresholds of the oracle for outside and inside the span of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OracleOptions {
    /// Outside: residual of the best imitation above this multiple of the noise.
    pub outside_above: f64,
    /// Inside: residual of the best imitation below this multiple of the noise.
    pub inside_below: f64,
    /// Maximum number of effects of an imitation, 1 to 3.
    pub most_effects: usize,
    /// Number of cases that share commands and the oracle's sensitivities.
    pub cases_per_commands: usize,
}

impl Default for OracleOptions {
    fn default() -> Self {
        OracleOptions {
            outside_above: 0.6,
            inside_below: 0.2,
            most_effects: 3,
            cases_per_commands: 10,
        }
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
            return Err(BadOption {
                key: "outside_above",
                found,
                expected: "at least inside_below",
            });
        }
        if !(1..=3).contains(&self.most_effects) {
            let found = self.most_effects.to_string();
            return Err(BadOption { key: "most_effects", found, expected: "1 to 3" });
        }
        BadOption::unless_counted("cases_per_commands", self.cases_per_commands)
    }
}

/// Prior of an uncertain parameter: normal about the value without influence; components of vectors
/// and tendons are independent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Prior {
    /// Effect that has the parameter.
    pub effect: String,
    /// The parameter.
    pub parameter: String,
    /// Standard deviation, in the parameter's unit.
    pub deviation: f64,
}
