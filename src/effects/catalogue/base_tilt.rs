//! The base is tilted with respect to the assumed direction of gravity.

use nalgebra::{UnitQuaternion, Vector3};

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};

/// The base is tilted about x and y; measurements are in the frame of the untilted base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseTilt {
    /// Rotation of the base about its own x, rad.
    pub tilt_x_rad: f64,
    /// Rotation of the base about its own y, rad.
    pub tilt_y_rad: f64,
}

pub(crate) const CARD: Card = Card {
    name: "base_tilt",
    missing: "tilt of the base relative to gravity",
    equation: "R(0) → R(0) exp((tilt_x, tilt_y, 0)^)",
    source: "rigid-body kinematics",
    parameters: &[
        Parameter { name: "tilt_x_rad", unit: "rad", null: 0.0, seek: Seek::Size(0.01) },
        Parameter { name: "tilt_y_rad", unit: "rad", null: 0.0, seek: Seek::Size(0.01) },
    ],
    usual_change: None,
    confused_with: &["frame_shift", "precurvature", "tip_force"],
};

impl Effect for BaseTilt {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_finite("tilt_x_rad", self.tilt_x_rad)?;
        BadOption::unless_finite("tilt_y_rad", self.tilt_y_rad)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        let tilt_rad = Vector3::new(self.tilt_x_rad, self.tilt_y_rad, 0.0);
        // For an upright base the rotation equals the tilt to the last bit.
        rod.base_rotation_rad = if rod.base_rotation_rad == Vector3::zeros() {
            tilt_rad
        } else {
            let turn = UnitQuaternion::from_scaled_axis(rod.base_rotation_rad);
            (turn * UnitQuaternion::from_scaled_axis(tilt_rad)).scaled_axis()
        };
    }
}
