//! The tracking frame is shifted.

use serde::{Deserialize, Serialize};

use super::{Card, Effect, Parameter, Seek};
use crate::base::BadOption;
use crate::base::Observation;

/// A constant offset between the tracked and the true tip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameShift {
    /// Added to the measured position, metres.
    pub shift_m: [f64; 3],
}

pub(super) const CARD: Card = Card {
    name: "frame_shift",
    missing: "tracking frame offset",
    equation: "tip measured = tip + shift",
    source: "rigid-body kinematics",
    parameters: &[
        Parameter { name: "shift_m[0]", unit: "m", null: 0.0, seek: Seek::Size(0.002) },
        Parameter { name: "shift_m[1]", unit: "m", null: 0.0, seek: Seek::Size(0.002) },
        Parameter { name: "shift_m[2]", unit: "m", null: 0.0, seek: Seek::Size(0.002) },
    ],
    confused_with: &["base_tilt"],
};

impl Effect for FrameShift {
    fn check(&self) -> Result<(), BadOption> {
        self.shift_m.iter().try_for_each(|&shift| super::finite("shift_m", shift))
    }

    fn observe(&self, seen: &mut Observation) {
        let positions =
            std::iter::once(&mut seen.tip_m).chain(seen.points.iter_mut().map(|point| &mut point.position_m));
        for position_m in positions {
            position_m.iter_mut().zip(self.shift_m).for_each(|(own, shift)| *own += shift);
        }
    }
}
