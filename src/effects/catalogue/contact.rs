//! A wall or a ball that the robot touches.

use nalgebra::{Matrix3, Vector3};

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, RodParams, Seek, Serialize};
use crate::math::rotation;
use crate::rod::{Obstacle, ObstacleShape};

/// A rigid, smooth obstacle beside the robot: a wall along the axis of the straight robot, or a
/// ball. Its place is that of the point of its surface that is nearest to this axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Distance of that point from the axis, metres.
    pub distance_m: f64,
    /// Its direction from the axis, from the base's x towards its y, rad.
    pub azimuth_rad: f64,
    /// Its place along the axis, metres from the base; of no influence on a wall.
    #[serde(default)]
    pub position_m: f64,
    /// One over the radius of the ball, 1/m; 0 for a wall, which is a half space.
    #[serde(default)]
    pub curvature_1_m: f64,
}

pub(crate) const CARD: Card = Card {
    name: "contact",
    missing: "a wall or a ball that the robot touches",
    equation: "gap(p(s)) ≥ r for all s, with a force ≥ 0 along the normal of the obstacle where \
               they are equal",
    source: "Wriggers 2006, Computational Contact Mechanics, section 4.1 (unilateral contact)",
    parameters: &[
        Parameter { name: "distance_m", unit: "m", null: 10.0, seek: Seek::Distance(0.002) },
        Parameter { name: "azimuth_rad", unit: "rad", null: 0.0, seek: Seek::Located(0.1) },
        Parameter { name: "position_m", unit: "m", null: 0.0, seek: Seek::Located(0.01) },
        Parameter { name: "curvature_1_m", unit: "1/m", null: 0.0, seek: Seek::Located(5.0) },
    ],
    usual_change: None,
    confused_with: &["tip_force", "backlash", "friction"],
};

/// A smaller curvature is that of a wall, 1/m.
const MIN_BALL_CURVATURE_1_M: f64 = 0.01;

impl Contact {
    /// Shape and place in the frame of the base at `base_m` with the rotation `base_r`.
    fn shape(&self, base_m: &Vector3<f64>, base_r: &Matrix3<f64>) -> ObstacleShape {
        let (sin, cos) = self.azimuth_rad.sin_cos();
        let outwards = base_r * Vector3::new(cos, sin, 0.0);
        let nearest_m = base_m + outwards * self.distance_m + base_r.column(2) * self.position_m;
        if self.curvature_1_m < MIN_BALL_CURVATURE_1_M {
            return ObstacleShape::HalfSpace {
                normal: -outwards,
                offset_m: -outwards.dot(&nearest_m),
            };
        }
        let radius_m = 1.0 / self.curvature_1_m;
        ObstacleShape::Sphere { center_m: nearest_m + outwards * radius_m, radius_m }
    }
}

impl Effect for Contact {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("distance_m", self.distance_m)?;
        BadOption::unless_finite("azimuth_rad", self.azimuth_rad)?;
        BadOption::unless_finite("position_m", self.position_m)?;
        BadOption::unless_not_negative("curvature_1_m", self.curvature_1_m)
    }

    fn modify_rod(&self, rod: &mut RodParams) {
        let shape = self.shape(&rod.base_m, &rotation::exp(&rod.base_rotation_rad));
        rod.contact.obstacles.push(Obstacle {
            shape,
            friction_coefficient: 0.0,
            stiffness_n_m: None,
        });
    }
}
