//! Conversion between tendon displacements and lead-screw positions.

use serde::{Deserialize, Serialize};

use crate::base::BadOption;

/// Number of lead screws.
pub const AXES: usize = 4;

/// Lead-screw positions with the tendons at home, and the direction in which each screw pulls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AxesOptions {
    /// Position of each axis (X, Y, Z, A) with its tendon at home, millimetres from its homing
    /// switch.
    pub home_mm: [f64; AXES],
    /// True for an axis that moves towards its switch when it pulls its tendon.
    pub reversed: [bool; AXES],
}

impl Default for AxesOptions {
    fn default() -> Self {
        AxesOptions { home_mm: [30.0; AXES], reversed: [false; AXES] }
    }
}

impl AxesOptions {
    /// Refuses home positions from which the limits cannot be reached: every axis must be able to
    /// move `travel_m` either way within 0 and `screw_m`.
    ///
    /// # Errors
    /// [`BadOption`] for the first such axis.
    pub fn check(&self, travel_m: f64, screw_m: f64) -> Result<(), BadOption> {
        // Else a permitted command could drive a screw onto its switch.
        let reaches = |&home_mm: &f64| {
            home_mm - travel_m * 1e3 >= 0.0 && home_mm + travel_m * 1e3 <= screw_m * 1e3
        };
        let expected = "a range of ±safety.travel_m within 0 to motion.travel_m";
        self.home_mm
            .iter()
            .try_for_each(|mm| BadOption::unless(reaches(mm), "home_mm", mm, expected))
    }

    /// Distances from the switches in millimetres for displacements in metres.
    pub fn from_switch_mm(&self, pulls_m: &[f64; AXES]) -> [f64; AXES] {
        std::array::from_fn(|axis| self.home_mm[axis] + self.sign(axis) * pulls_m[axis] * 1e3)
    }

    /// Displacements in metres for distances from the switches in millimetres.
    pub fn pulls_m(&self, from_switch_mm: &[f64; AXES]) -> [f64; AXES] {
        std::array::from_fn(|axis| {
            self.sign(axis) * (from_switch_mm[axis] - self.home_mm[axis]) * 1e-3
        })
    }

    fn sign(&self, axis: usize) -> f64 {
        if self.reversed[axis] { -1.0 } else { 1.0 }
    }
}
