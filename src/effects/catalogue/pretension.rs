//! The tendons of one segment are tighter, or less tight.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// An equal change of the pretension of all tendons that end with one segment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pretension {
    /// Segment, from 1 at the base.
    pub segment: usize,
    /// Added to the displacement of its tendons at home, metres.
    pub change_m: f64,
}

pub(crate) const CARD: Card = Card {
    name: "pretension",
    missing: "different pretension of the tendons of one segment",
    equation: "q_i → q_i + change for all tendons that end with the segment",
    source: "homing error of a common carriage",
    parameters: &[
        Parameter { null: 1.0, ..Parameter::SEGMENT },
        Parameter { name: "change_m", unit: "m", null: 0.0, seek: Seek::Size(0.001) },
    ],
    usual_change: None,
    confused_with: &["actuator_offset", "bending_stiffness", "tendon_stretch"],
};

impl Effect for Pretension {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_counted("segment", self.segment)?;
        BadOption::unless_finite("change_m", self.change_m)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        let [start_m, end_m] = rod.segment_m(self.segment);
        let ends_there = |end: f64| end > start_m && end <= end_m;
        for tendon in rod.tendons.iter_mut().filter(|tendon| ends_there(tendon.end_m)) {
            tendon.pretension_m += self.change_m;
        }
    }

    fn segment(&self) -> Option<usize> {
        Some(self.segment)
    }
}
