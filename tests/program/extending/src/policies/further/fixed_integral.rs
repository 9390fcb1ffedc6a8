//! Integral feedback without a model: the tip's error in x and y is integrated by a fixed matrix into pulls on
//! antagonistic tendons.

use serde::{Deserialize, Serialize};

use crate::base::series::SeriesLabel;
use crate::base::{BadOption, Displacements, Point3, PolicyError};
use crate::policies::parts::single_controller::{ControlLaw, Demand, SingleController};
use crate::policies::parts::tip_tracker::TipReading;
use crate::policies::{ModelAccess, PolicyEntry};

/// What a tip error towards x and y adds to each of four tendons at 0°, 90°, 180° and 270°.
const DIRECTIONS: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "fixed_integral",
    label: SeriesLabel::text("fixed integral"),
    look: None,
    footnote: "",
    needs: &[],
    model: ModelAccess::None,
    closed_loop_only: true,
    make: |_, options| {
        let controller = FixedIntegralController {
            options: options.fixed_integral,
            pulls_m: vec![0.0; DIRECTIONS.len()],
        };
        Ok(Box::new(SingleController::new(controller, "", options)))
    },
};

/// Options of the integral controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FixedIntegralOptions {
    /// Displacement of a tendon per distance of the tip from the target, in each tick.
    pub gain: f64,
    /// The policy has settled when the tip is this near to the target in x and y, metres.
    pub settled_m: f64,
}

impl Default for FixedIntegralOptions {
    fn default() -> Self {
        FixedIntegralOptions { gain: 0.06, settled_m: 0.001 }
    }
}

impl FixedIntegralOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("gain", self.gain)?;
        BadOption::unless_positive("settled_m", self.settled_m)
    }
}

struct FixedIntegralController {
    options: FixedIntegralOptions,
    /// The integral.
    pulls_m: Displacements,
}

impl ControlLaw for FixedIntegralController {
    fn reset(&mut self) {
        self.pulls_m.fill(0.0);
    }

    fn decide(&mut self, reading: TipReading, target_m: &Point3) -> Result<Demand, PolicyError> {
        let error_m = [target_m[0] - reading.tip_m[0], target_m[1] - reading.tip_m[1]];
        // Without a new measurement the error is not known: the command stays.
        if reading.fresh {
            for (pull_m, direction) in self.pulls_m.iter_mut().zip(DIRECTIONS) {
                *pull_m +=
                    self.options.gain * (direction[0] * error_m[0] + direction[1] * error_m[1]);
            }
        }
        let settled = error_m[0].hypot(error_m[1]) <= self.options.settled_m;
        Ok(Demand { pulls_m: self.pulls_m.clone(), settled })
    }
}
