//! How a discovery is carried out.

use serde::{Deserialize, Serialize};

use crate::base::{BadOption, Seed};
use crate::effects::Model;

/// A number of the robot that its file knows only so well.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Uncertainty {
    /// The effect whose parameter it is.
    pub effect: String,
    /// The parameter; all components of a vector, all tendons.
    pub parameter: String,
    /// Standard deviation about the value at which the effect changes nothing.
    pub deviation: f64,
}

/// How a discovery is carried out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Share of the trials that take no part in naming or fitting; which ones is chosen by their commands.
    pub held_out_share: f64,
    /// Effects that are named together at most.
    pub most_effects: usize,
    /// What an effect must add to the score (penalised, in units of 2 ln) to be taken.
    pub least_score: f64,
    /// How far an effect must move the tip, over the noise floor, to be worth a name.
    pub least_size: f64,
    /// How far one effect more must move the tip, over what those found before it do: their laws are right to no more.
    pub least_share: f64,
    /// Answers whose scores differ by less cannot be told apart.
    pub rival_score: f64,
    /// Chance that noise alone is taken for something missing.
    pub false_alarm: f64,
    /// What is foretold of the residual, over the noise floor, is not worth mentioning below this.
    pub least_foretold: f64,
    /// Effects that are left out of the catalogue.
    pub left_out: Vec<String>,
    /// What is not known exactly of any robot, and free in every candidate alike.
    pub uncertain: Vec<Uncertainty>,
    /// Precision in time with which the model is simulated_m, metres. An error of a tenth of the noise in every sample would
    /// tell candidates apart that the data do not.
    pub motion_tolerance_m: f64,
    /// Length of a cell of the grid on which it is simulated_m, metres; the model's own where that is longer. Cells go across
    /// jumps of the material.
    pub cell_m: f64,
    /// What moves the tip by less than this share of the backbone's length is neither named nor missed, whatever the noise:
    /// no model of a robot is right to that, and a recording that was simulated may not be either.
    pub least_of_length: f64,
    /// Seed of the permutation test.
    pub seed: u64,
}

/// What a calibration on 400 samples leaves unknown: two to three times what each number alone would keep, 0.5 mm over
/// the tip's answer to it and √400, because they are found together (docs/discovery.md).
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
        for (key, value) in [("held_out_share", self.held_out_share), ("false_alarm", self.false_alarm)] {
            if !(value > 0.0 && value < 1.0) {
                return Err(BadOption { key, found: value.to_string(), expected: "a number between 0 and 1" });
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
        ];
        for (key, value) in sizes {
            if !(value.is_finite() && value >= 0.0) {
                return Err(BadOption { key, found: value.to_string(), expected: "a finite number of at least 0" });
            }
        }
        self.uncertain.iter().try_for_each(|one| BadOption::unless_positive("deviation", one.deviation))
    }

    /// What moves the tip of this robot by less is neither named nor missed, metres.
    pub(super) fn least_m(&self, model: &Model) -> f64 {
        self.least_of_length * model.robot.backbone.length_m
    }

    pub(super) fn limits(&self, model: &Model) -> SearchLimits {
        SearchLimits {
            most_effects: self.most_effects,
            least_score: self.least_score,
            least_size: self.least_size,
            least_share: self.least_share,
            least_m: self.least_m(model),
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

/// How far the search goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct SearchLimits {
    /// Effects at most.
    pub(super) most_effects: usize,
    /// Score that an effect must add to be taken.
    pub(super) least_score: f64,
    /// Distance that an effect must move the tip, over the noise floor.
    pub(super) least_size: f64,
    /// The same for one effect more, over what those found before it do together.
    pub(super) least_share: f64,
    /// The same in metres, whatever the noise.
    pub(super) least_m: f64,
    /// Sets whose scores are nearer are rivals.
    pub(super) rival_score: f64,
    /// Beside sets of fewer effects every candidate is fitted, whatever it predictions at a first look.
    pub(super) exhaustive_below: usize,
}

impl SearchLimits {
    /// How far an effect must move the tip beside a set that leaves this noise, metres.
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
            Options { motion_tolerance_m, cell_m, ..Options::default() }.check().map_err(|error| error.key)
        };
        assert_eq!(Options::default().check(), Ok(()));
        assert_eq!(check(1.0, 0.03), Err("motion_tolerance_m"));
        assert_eq!(check(3e-5, 1e-9), Err("cell_m"));
        assert_eq!(check(f64::NAN, 0.03), Err("motion_tolerance_m"));
    }
}
