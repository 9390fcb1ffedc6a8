//! The tracking frame is shifted.

use crate::effects::{
    BadOption, Card, Deserialize, Effect, Observation, Parameter, Seek, Serialize,
};

/// A constant offset between the tracked and the true tip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameShift {
    /// Added to the measured position, metres.
    pub shift_m: [f64; 3],
}

pub(crate) const CARD: Card = Card {
    name: "frame_shift",
    missing: "offset of the tracking frame",
    equation: "tip measured = tip + shift",
    source: "rigid-body kinematics",
    parameters: &[
        Parameter { name: "shift_m[0]", unit: "m", null: 0.0, seek: Seek::Size(0.002) },
        Parameter { name: "shift_m[1]", unit: "m", null: 0.0, seek: Seek::Size(0.002) },
        Parameter { name: "shift_m[2]", unit: "m", null: 0.0, seek: Seek::Size(0.002) },
    ],
    usual_change: None,
    confused_with: &["base_tilt"],
};

impl Effect for FrameShift {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_all_finite("shift_m", &self.shift_m)
    }

    fn observe(&self, seen: &mut Observation) {
        for position_m in seen.positions_m() {
            position_m
                .iter_mut()
                .zip(self.shift_m)
                .for_each(|(coordinate, shift)| *coordinate += shift);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{BodyPoint, DrivenModel, EffectSpec, Model};

    #[test]
    fn the_tip_and_all_points_are_shifted() {
        let mut model = Model::default();
        model
            .tracking
            .points
            .insert("mid".to_owned(), BodyPoint { s_m: 0.1, offset_m: [0.0, 0.01, 0.0] });
        let shift_m = [0.003, -0.002, 0.001];
        let positions = |extra: &[EffectSpec]| {
            let mut driven = DrivenModel::new(&model, extra);
            driven.home().unwrap();
            driven
                .observation(&[], 0.0)
                .positions_m()
                .map(|position_m| *position_m)
                .collect::<Vec<_>>()
        };
        let (plain, shifted) =
            (positions(&[]), positions(&[EffectSpec::FrameShift(FrameShift { shift_m })]));
        assert_eq!(plain.len(), 2);
        for (plain, shifted) in plain.iter().zip(&shifted) {
            (0..3).for_each(|axis| {
                assert!((shifted[axis] - plain[axis] - shift_m[axis]).abs() < 1e-15)
            });
        }
    }
}
