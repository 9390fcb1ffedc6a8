//! Integral feedback without a model and without data: in each tick the tip's error in x and y is
//! integrated by a fixed gain into pulls on the tendons that lie in its direction.

use crate::base::{BadOption, Point3, PolicyError};
use crate::policies::parts::bends::BendDirections;
use crate::policies::parts::single_controller::{ControlLaw, Demand, SingleController};
use crate::policies::parts::tip_tracker::TipReading;
use crate::policies::{Deserialize, ModelAccess, PolicyEntry, Serialize, SeriesLabel};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "integral",
    label: SeriesLabel::text("integral"),
    footnote: "integral feedback without model and data.",
    model: ModelAccess::Tendons,
    closed_loop_only: true,
    make: |parts, options| {
        let bends = BendDirections::new(parts.layout("integral")?, options.limits);
        let controller =
            IntegralController { bend_m: vec![0.0; bends.len()], bends, options: options.integral };
        Ok(Box::new(SingleController::new(controller, "", options)))
    },
    ..PolicyEntry::PLAIN
};

/// Options of the integral controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct IntegralOptions {
    /// Displacement of a tendon for each metre of the tip's error towards it, in each tick, metres.
    pub gain: f64,
    /// The policy has settled when the measured tip is within this distance of the target in x and
    /// y.
    pub settled_m: f64,
}

impl Default for IntegralOptions {
    fn default() -> Self {
        // A metre of tendon moves the tip by 3 to 5 metres, so that an error shrinks by a quarter
        // or less in a tick.
        IntegralOptions { gain: 0.05, settled_m: 0.001 }
    }
}

impl IntegralOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("gain", self.gain)?;
        BadOption::unless_positive("settled_m", self.settled_m)
    }
}

struct IntegralController {
    bends: BendDirections,
    options: IntegralOptions,
    /// The integral: the same in every segment.
    bend_m: Vec<f64>,
}

impl ControlLaw for IntegralController {
    fn reset(&mut self) {
        self.bend_m.fill(0.0);
    }

    fn decide(&mut self, reading: TipReading, target_m: &Point3) -> Result<Demand, PolicyError> {
        let error_m = [target_m[0] - reading.tip_m[0], target_m[1] - reading.tip_m[1]];
        // Without a new measurement the error is not known: the command stays.
        if reading.fresh {
            let change_m =
                error_m.map(|error_m| self.options.gain * error_m).repeat(self.bend_m.len() / 2);
            self.bends.advance(&mut self.bend_m, &change_m);
        }
        let settled = error_m[0].hypot(error_m[1]) <= self.options.settled_m;
        Ok(Demand { pulls_m: self.bends.pulls_m(&self.bend_m), settled })
    }
}
