//! A wall that the robot touches: a half space at a distance.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Card, Effect, Parameter, Seek};
use crate::base::BadOption;
use crate::rod::{Obstacle, ObstacleShape, RodParams};

/// A rigid, smooth wall. Its direction is that from the origin of the world frame to its nearest point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Distance of the wall from the origin, metres.
    pub distance_m: f64,
    /// Direction of the wall from x towards y, rad.
    pub azimuth_rad: f64,
    /// Direction of the wall from the plane of x and y towards z, rad.
    #[serde(default)]
    pub elevation_rad: f64,
}

pub(super) const CARD: Card = Card {
    name: "contact",
    missing: "a wall that the robot touches",
    equation: "e·p(s) + r ≤ distance for all s, with a force ≥ 0 against e = (cos ε cos α, cos ε sin α, sin ε)",
    source: "Wriggers 2006, Computational Contact Mechanics, section 4.1 (unilateral contact)",
    parameters: &[
        Parameter { name: "distance_m", unit: "m", null: 10.0, seek: Seek::Distance(0.002) },
        Parameter { name: "azimuth_rad", unit: "rad", null: 0.0, seek: Seek::Angle },
        Parameter { name: "elevation_rad", unit: "rad", null: 0.0, seek: Seek::Angle },
    ],
    confused_with: &["tip_force", "backlash", "friction"],
};

impl Effect for Contact {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("distance_m", self.distance_m)?;
        super::finite("azimuth_rad", self.azimuth_rad)?;
        super::finite("elevation_rad", self.elevation_rad)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        let ((sin, cos), (up, level)) = (self.azimuth_rad.sin_cos(), self.elevation_rad.sin_cos());
        let shape =
            ObstacleShape::HalfSpace { normal: -Vector3::new(level * cos, level * sin, up), offset_m: -self.distance_m };
        rod.contact.obstacles.push(Obstacle { shape, friction_coefficient: 0.0, stiffness_n_m: None });
    }
}
