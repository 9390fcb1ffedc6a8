//! The tracker's unit of length is off.

use crate::effects::{
    BadOption, Card, Deserialize, Effect, Observation, Parameter, Seek, Serialize,
};

/// Every measured position is scaled about the origin of the base frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackerScale {
    /// Measured length over true length.
    pub scale: f64,
}

pub(crate) const CARD: Card = Card {
    name: "tracker_scale",
    missing: "the tracker's unit of length is off",
    equation: "p_measured = scale · p",
    source: "calibration of the tracking volume",
    parameters: &[Parameter { name: "scale", unit: "1", null: 1.0, seek: Seek::Size(0.01) }],
    confused_with: &["frame_shift"],
    usual_change: None,
};

impl Effect for TrackerScale {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("scale", self.scale)
    }

    fn observe(&self, seen: &mut Observation) {
        seen.positions_m().flatten().for_each(|position_m| *position_m *= self.scale);
    }
}
