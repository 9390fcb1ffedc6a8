//! Options of a discovery.

use serde::{Deserialize, Serialize};

use super::recording::blocks::Playing;
use super::recording::samples::Samples;
use crate::base::{BadOption, Seed};
use crate::data::Recording;
use crate::effects::Model;

/// A parameter of the robot with a known uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Uncertainty {
    /// Effect that has the parameter.
    pub effect: String,
    /// The parameter; all components of a vector, all tendons.
    pub parameter: String,
    /// Standard deviation about the value at which the effect has no influence.
    pub deviation: f64,
}

/// Options of a discovery.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Share of held-out trials. The selection depends only on their commands.
    pub held_out_share: f64,
    /// Maximum number of effects named together.
    pub most_effects: usize,
    /// Minimum gain in score (2 ln likelihood minus penalty) of an added effect.
    pub least_score: f64,
    /// Minimum tip displacement of an effect, as a multiple of the noise floor.
    pub least_size: f64,
    /// Minimum tip displacement of an additional effect, as a share of that of the effects found
    /// before; the laws of the catalogue are not more accurate.
    pub least_share: f64,
    /// Largest difference in score between rival sets.
    pub rival_score: f64,
    /// Significance level of the goodness-of-fit tests.
    pub false_alarm: f64,
    /// Minimum size of a predictable residual, as a multiple of the noise floor, to be reported.
    pub least_foretold: f64,
    /// Effects that are excluded from the search.
    pub left_out: Vec<String>,
    /// Uncertain parameters: free within their uncertainty in every candidate.
    pub uncertain: Vec<Uncertainty>,
    /// Time-stepping tolerance of simulations, metres. Larger errors would distinguish candidates
    /// that the data do not distinguish.
    pub motion_tolerance_m: f64,
    /// Largest grid cell of simulations, metres; the model's own value if that is larger. Cells may
    /// span material jumps.
    pub cell_m: f64,
    /// Tip displacements below this share of the backbone's length are neither named nor reported
    /// as missing at any noise level; no model is more accurate.
    pub least_of_length: f64,
    /// Model-form error, metres: residual beyond noise of a model on an unchanged robot. A baseline
    /// measures it; without a baseline, this value is used. Use zero for simulated robots and the
    /// held-out error of the calibration for a real robot.
    pub model_form_m: f64,
    /// Residuals below this multiple of the model-form error are not attributed to a missing
    /// effect.
    pub form_margin: f64,
    /// If the model has a model-form error: one effect that explains at least this share of the gap
    /// is named even if a residual remains.
    pub least_explained: f64,
    /// Treat every row as a pose at rest under its own command; ignore the times.
    pub at_rest: bool,
    /// Seed of the permutation test.
    pub seed: u64,
}

/// Uncertainty that a calibration on 400 samples leaves: two to three times the value for each
/// parameter alone (0.5 mm over the tip's sensitivity and √400), because the parameters are fitted
/// together (docs/reference/discovery.md).
const UNCERTAIN: &[(&str, &str, f64)] = &[
    ("bending_stiffness", "scale", 0.003),
    ("spine_compressibility", "scale", 0.005),
    ("distributed_mass", "scale", 0.005),
    ("damping", "time_s", 0.003),
    ("tendon_radius", "scale", 0.001),
    ("base_tilt", "tilt_x_rad", 3e-4),
    ("base_tilt", "tilt_y_rad", 3e-4),
    ("frame_shift", "shift_m", 6e-5),
    ("actuator_offset", "offset_m", 1e-5),
];

impl Default for Options {
    fn default() -> Self {
        let uncertain = UNCERTAIN.iter().map(|&(effect, parameter, deviation)| Uncertainty {
            effect: effect.to_owned(),
            parameter: parameter.to_owned(),
            deviation,
        });
        Options {
            held_out_share: 0.25,
            most_effects: 3,
            least_score: 12.0,
            least_size: 0.5,
            least_share: 0.1,
            rival_score: 6.0,
            false_alarm: 1e-3,
            least_foretold: 0.4,
            left_out: Vec::new(),
            uncertain: uncertain.collect(),
            motion_tolerance_m: 3e-5,
            cell_m: 0.03,
            least_of_length: 1e-3,
            model_form_m: 0.0,
            form_margin: 1.5,
            least_explained: 0.8,
            at_rest: false,
            seed: 0,
        }
    }
}

impl Options {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        let shares = [
            ("held_out_share", self.held_out_share),
            ("false_alarm", self.false_alarm),
            ("least_explained", self.least_explained),
        ];
        for (key, value) in shares {
            if !(value > 0.0 && value < 1.0) {
                return Err(BadOption {
                    key,
                    found: value.to_string(),
                    expected: "a number between 0 and 1",
                });
            }
        }
        BadOption::unless_counted("most_effects", self.most_effects)?;
        let lengths = [
            ("motion_tolerance_m", self.motion_tolerance_m, [1e-7, 1e-3], "1e-7 to 0.001 m"),
            ("cell_m", self.cell_m, [1e-4, 1.0], "0.0001 to 1 m"),
        ];
        for (key, value, [least, most], expected) in lengths {
            if !(least..=most).contains(&value) {
                return Err(BadOption { key, found: value.to_string(), expected });
            }
        }
        let sizes = [
            ("least_score", self.least_score),
            ("least_size", self.least_size),
            ("least_share", self.least_share),
            ("rival_score", self.rival_score),
            ("least_foretold", self.least_foretold),
            ("least_of_length", self.least_of_length),
            ("model_form_m", self.model_form_m),
            ("form_margin", self.form_margin),
        ];
        for (key, value) in sizes {
            if !(value.is_finite() && value >= 0.0) {
                return Err(BadOption {
                    key,
                    found: value.to_string(),
                    expected: "a finite number of at least 0",
                });
            }
        }
        self.uncertain
            .iter()
            .try_for_each(|one| BadOption::unless_positive("deviation", one.deviation))
    }

    /// How the rows of a recording of this robot follow each other.
    pub(super) fn playing(&self, model: &Model) -> Playing {
        Playing { starts: model.tracking.starts, at_rest: self.at_rest }
    }

    /// Samples of a recording of this robot: the tip and the points that the model places.
    pub(super) fn samples(&self, model: &Model, measured: &Recording) -> Samples {
        Samples::played(measured, &model.tracking.names(), self.playing(model))
    }

    /// Smallest tip displacement that is relevant for this robot, metres.
    pub(super) fn least_m(&self, model: &Model) -> f64 {
        self.least_of_length * model.robot.backbone.length_m
    }

    /// Limits of the search for a robot of which the model leaves `model_form_m` beyond noise.
    pub(super) fn limits(&self, model: &Model, model_form_m: f64) -> SearchLimits {
        SearchLimits {
            most_effects: self.most_effects,
            least_score: self.least_score,
            least_size: self.least_size,
            least_share: self.least_share,
            least_m: self.least_m(model),
            least_gain_m: self.form_margin * model_form_m,
            rival_score: self.rival_score,
            exhaustive_below: 0,
        }
    }

    /// Whether a parameter of this effect is uncertain.
    pub(super) fn is_uncertain(&self, effect: &str) -> bool {
        self.uncertain.iter().any(|one| one.effect == effect)
    }

    pub(super) fn seed(&self) -> Seed {
        Seed(self.seed).child("discovery")
    }
}

/// Limits of the search.
#[derive(Clone, Copy, Debug)]
pub(super) struct SearchLimits {
    /// Maximum number of effects.
    pub(super) most_effects: usize,
    /// Minimum gain in score of an added effect.
    pub(super) least_score: f64,
    /// Minimum tip displacement of an effect, as a multiple of the noise floor.
    pub(super) least_size: f64,
    /// Minimum tip displacement of an additional effect, as a share of that of the effects before
    /// it.
    pub(super) least_share: f64,
    /// Minimum tip displacement, metres, whatever the noise.
    pub(super) least_m: f64,
    /// Minimum fall of the rms residual by an added effect, metres (squares subtract): less may be
    /// what the model leaves on this robot anyway.
    pub(super) least_gain_m: f64,
    /// Largest difference in score between rival sets.
    pub(super) rival_score: f64,
    /// Sets with fewer effects than this are extended by every candidate, whatever the screening
    /// predicts.
    pub(super) exhaustive_below: usize,
}

impl SearchLimits {
    /// Minimum tip displacement, metres, of an effect added to a set whose residual noise has this
    /// rms.
    pub(super) fn least_m(&self, noise_rms_m: f64) -> f64 {
        self.least_m.max(self.least_size * noise_rms_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_precision_that_hides_the_gap_is_refused() {
        let check = |motion_tolerance_m: f64, cell_m: f64| {
            Options { motion_tolerance_m, cell_m, ..Options::default() }
                .check()
                .map_err(|error| error.key)
        };
        assert_eq!(Options::default().check(), Ok(()));
        assert_eq!(check(1.0, 0.03), Err("motion_tolerance_m"));
        assert_eq!(check(3e-5, 1e-9), Err("cell_m"));
        assert_eq!(check(f64::NAN, 0.03), Err("motion_tolerance_m"));
    }
}
