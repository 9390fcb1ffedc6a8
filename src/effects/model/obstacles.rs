//! Obstacles that the robot of a model may touch.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::base::BadOption;
use crate::rod::{self, ObstacleShape};

/// A fixed obstacle: one shape and its contact law.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleSpec {
    /// The half space behind a plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<Plane>,
    /// A ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sphere: Option<Sphere>,
    /// A round cylinder with flat ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cylinder: Option<Cylinder>,
    /// All points within a radius of a line segment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capsule: Option<Capsule>,
    /// Coefficient of Coulomb friction.
    #[serde(default)]
    pub friction_coefficient: f64,
    /// Force per penetration at each point of contact, N/m; default: rigid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_n_m: Option<f64>,
}

/// All points whose distance from the origin along the normal is at most `distance_m`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// Normal, out of the obstacle, world frame; any length but zero.
    pub normal: [f64; 3],
    /// Distance of the plane from the origin along the normal, metres; negative behind the origin.
    pub distance_m: f64,
}

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Its centre, world frame, metres.
    pub center_m: [f64; 3],
    /// Its radius, metres.
    pub radius_m: f64,
}

/// A round cylinder with flat ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// The middle of its axis, world frame, metres.
    pub center_m: [f64; 3],
    /// The direction of its axis, world frame; any length but zero.
    pub axis: [f64; 3],
    /// Its radius, metres.
    pub radius_m: f64,
    /// Its length, metres; default: infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
}

/// All points within a radius of a line segment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Capsule {
    /// One end of the segment, world frame, metres.
    pub start_m: [f64; 3],
    /// The other end.
    pub end_m: [f64; 3],
    /// The radius, metres.
    pub radius_m: f64,
}

/// Shortest vector that is a direction.
const MIN_DIRECTION_NORM: f64 = 1e-9;

impl ObstacleSpec {
    /// Refuses numbers that make no obstacle.
    ///
    /// # Errors
    /// The key of the shape (empty: the obstacle's own keys) and the expected range.
    pub(crate) fn check(&self) -> Result<(), (&'static str, BadOption)> {
        let count = self.shapes().count();
        if count != 1 {
            let found = format!("{count} shapes in one obstacle");
            let expected = "one of `plane`, `sphere`, `cylinder` and `capsule`";
            return Err(("", BadOption { key: self.shape_name(), found, expected }));
        }
        let at = |key: &'static str| move |error: BadOption| (key, error);
        self.plane.map_or(Ok(()), |plane| plane.check()).map_err(at("plane"))?;
        self.sphere.map_or(Ok(()), |sphere| sphere.check()).map_err(at("sphere"))?;
        self.cylinder.map_or(Ok(()), |cylinder| cylinder.check()).map_err(at("cylinder"))?;
        self.capsule.map_or(Ok(()), |capsule| capsule.check()).map_err(at("capsule"))?;
        BadOption::unless_not_negative("friction_coefficient", self.friction_coefficient)
            .map_err(at(""))?;
        BadOption::unless_positive_or_null("stiffness_n_m", self.stiffness_n_m).map_err(at(""))
    }

    /// The keys of the shapes that are given.
    fn shapes(&self) -> impl Iterator<Item = &'static str> {
        let shapes = [
            (self.plane.is_some(), "plane"),
            (self.sphere.is_some(), "sphere"),
            (self.cylinder.is_some(), "cylinder"),
            (self.capsule.is_some(), "capsule"),
        ];
        shapes.into_iter().filter(|(present, _)| *present).map(|(_, name)| name)
    }

    /// The key of its shape.
    pub(crate) fn shape_name(&self) -> &'static str {
        self.shapes().next().unwrap_or("plane")
    }

    /// The obstacle as the rod has it; `None` without a shape.
    pub(crate) fn for_rod(&self) -> Option<rod::Obstacle> {
        let plane = self.plane.map(|plane| half_space(plane.normal, plane.distance_m));
        let sphere = self.sphere.map(|sphere| ObstacleShape::Sphere {
            center_m: Vector3::from(sphere.center_m),
            radius_m: sphere.radius_m,
        });
        let cylinder = self.cylinder.map(|cylinder| ObstacleShape::Cylinder {
            center_m: Vector3::from(cylinder.center_m),
            axis: Vector3::from(cylinder.axis).normalize(),
            radius_m: cylinder.radius_m,
            length_m: cylinder.length_m.unwrap_or(f64::INFINITY),
        });
        let capsule = self.capsule.map(|capsule| ObstacleShape::Capsule {
            ends_m: [Vector3::from(capsule.start_m), Vector3::from(capsule.end_m)],
            radius_m: capsule.radius_m,
        });
        Some(rod::Obstacle {
            shape: plane.or(sphere).or(cylinder).or(capsule)?,
            friction_coefficient: self.friction_coefficient,
            stiffness_n_m: self.stiffness_n_m,
        })
    }
}

/// All points whose distance from the origin along `normal` is at most `distance_m`.
pub(crate) fn half_space(normal: [f64; 3], distance_m: f64) -> ObstacleShape {
    ObstacleShape::HalfSpace { normal: Vector3::from(normal).normalize(), offset_m: distance_m }
}

impl Plane {
    fn check(&self) -> Result<(), BadOption> {
        direction("normal", &self.normal)?;
        BadOption::unless_finite("distance_m", self.distance_m)
    }
}

impl Sphere {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_all_finite("center_m", &self.center_m)?;
        BadOption::unless_positive("radius_m", self.radius_m)
    }
}

impl Cylinder {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_all_finite("center_m", &self.center_m)?;
        direction("axis", &self.axis)?;
        BadOption::unless_positive("radius_m", self.radius_m)?;
        BadOption::unless_positive_or_null("length_m", self.length_m)
    }
}

impl Capsule {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_all_finite("start_m", &self.start_m)?;
        BadOption::unless_all_finite("end_m", &self.end_m)?;
        BadOption::unless_positive("radius_m", self.radius_m)
    }
}

/// Refuses a vector that has no direction.
pub(crate) fn direction(key: &'static str, direction: &[f64; 3]) -> Result<(), BadOption> {
    BadOption::unless_all_finite(key, direction)?;
    let has_length = Vector3::from(*direction).norm() > MIN_DIRECTION_NORM;
    BadOption::unless(has_length, key, format!("{direction:?}"), "a vector that is not zero")
}
