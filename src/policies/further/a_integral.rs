//! Policy A with integral action: what remains between target and tip, once the command has been
//! reached, is added to the target that Algorithm 2 is given.

use crate::base::{BadOption, Point3, PolicyError, distance_m};
use crate::policies::paper::a::AlgorithmTwo;
use crate::policies::parts::actuator_limits::ActuatorLimits;
use crate::policies::parts::single_controller::{ControlLaw, Demand, SingleController};
use crate::policies::parts::tip_tracker::TipReading;
use crate::policies::{Deserialize, INVERSE, ModelNeed, PolicyEntry, Serialize, SeriesLabel};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "a_integral",
    label: SeriesLabel::text("A + integral"),
    footnote: "A whose target is moved by the integral of the error.",
    needs: &[ModelNeed::Network(&INVERSE), ModelNeed::ErrorModel],
    closed_loop_only: true,
    make: |mut parts, options| {
        let model = parts.inverse("a_integral", &INVERSE)?;
        let error = parts.error("a_integral")?;
        let controller = IntegratedA {
            a: AlgorithmTwo::new(model, error, options),
            options: options.a_integral,
            limits: ActuatorLimits::new(options.limits),
            arrived: false,
            target_m: None,
            offset_m: [0.0; 3],
        };
        Ok(Box::new(SingleController::new(controller, "", options)))
    },
    ..PolicyEntry::PLAIN
};

/// Options of A with integral action.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AIntegralOptions {
    /// Share of the error that a tick adds to the target: above 0, at most 1.
    pub gain: f64,
    /// Largest shift of the target.
    pub most_m: f64,
    /// The policy has settled when the measured tip is within this distance of the target.
    pub settled_m: f64,
}

impl Default for AIntegralOptions {
    fn default() -> Self {
        AIntegralOptions { gain: 0.1, most_m: 0.03, settled_m: 0.0012 }
    }
}

impl AIntegralOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_share("gain", self.gain)?;
        BadOption::unless_positive("most_m", self.most_m)?;
        BadOption::unless_positive("settled_m", self.settled_m)
    }
}

struct IntegratedA {
    a: AlgorithmTwo,
    options: AIntegralOptions,
    /// A copy of the drive's limits, to know when the command in force is the one that was
    /// demanded.
    limits: ActuatorLimits,
    arrived: bool,
    target_m: Option<Point3>,
    offset_m: Point3,
}

impl IntegratedA {
    /// Adds a share of the error, and keeps the sum within its bound.
    fn integrate(&mut self, error_m: Point3) {
        for (offset_m, error_m) in self.offset_m.iter_mut().zip(error_m) {
            *offset_m += self.options.gain * error_m;
        }
        let length_m = distance_m(&self.offset_m, &[0.0; 3]);
        let share = (self.options.most_m / length_m).min(1.0);
        self.offset_m.iter_mut().for_each(|offset_m| *offset_m *= share);
    }
}

impl ControlLaw for IntegratedA {
    fn reset(&mut self) {
        self.a.reset();
        self.target_m = None;
        self.offset_m = [0.0; 3];
        self.limits.reset();
        self.arrived = false;
    }

    fn decide(&mut self, reading: TipReading, target_m: &Point3) -> Result<Demand, PolicyError> {
        let aim_m: Point3 = std::array::from_fn(|axis| target_m[axis] + self.offset_m[axis]);
        // The same target as before, moved: the loop of Algorithm 2 goes on. At another one it
        // begins again.
        if self.target_m == Some(*target_m) {
            self.a.retarget(&aim_m);
        }
        self.target_m = Some(*target_m);
        let error_m: Point3 = std::array::from_fn(|axis| target_m[axis] - reading.tip_m[axis]);
        // The integral waits while the drive is on its way: it would wind up.
        if reading.fresh && self.arrived {
            self.integrate(error_m);
        }
        let pulls_m = self.a.decide(reading, &aim_m)?.pulls_m;
        self.arrived = self.limits.apply(&pulls_m, &vec![0.0; pulls_m.len()])?.arrived;
        let settled = distance_m(&error_m, &[0.0; 3]) <= self.options.settled_m;
        Ok(Demand { pulls_m, settled })
    }
}
