//! What a tracker follows on the robot's body.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::base::{BadOption, SeenPoint, is_default};
use crate::math::rotation;
use crate::rod::Rod;

/// Upper bound on tracked points.
const MAX_POINTS: usize = 1000;

/// How the robot is tracked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tracking {
    /// Tracked points by name: that of the columns `point_NAME_x_m,point_NAME_y_m,point_NAME_z_m`
    /// of a recording.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub points: BTreeMap<String, BodyPoint>,
    /// Place on the body of the tip in recordings; default: the end of the backbone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip: Option<BodyPoint>,
    /// State at the start of a trial.
    #[serde(default, skip_serializing_if = "is_default")]
    pub starts: Starts,
    /// With `starts: home`: time at home before a trial of a robot that was straight and free of
    /// stress, s; default: infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rested_s: Option<f64>,
}

/// State at the start of a trial.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Starts {
    /// At rest at home, all displacements 0.
    #[default]
    Home,
    /// At rest under the first command of the trial, without memory of earlier motion.
    Anywhere,
    /// The final state of the previous trial, at rest under its last command; the first trial
    /// starts at home.
    Continue,
}

impl Starts {
    /// What it means, as a sentence for the user; none for the default.
    pub fn told(self) -> Option<&'static str> {
        match self {
            Starts::Home => None,
            Starts::Anywhere => {
                Some("Each trial starts at rest under its first command (starts: anywhere).")
            }
            Starts::Continue => Some(
                "Each trial continues from the final state of the previous trial (starts: \
                 continue).",
            ),
        }
    }
}

/// Place of a tracked point on the body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyPoint {
    /// Distance from the base along the unloaded backbone, metres.
    pub s_m: f64,
    /// Offset from the backbone along the axes of the cross-section there, metres.
    #[serde(default)]
    pub offset_m: [f64; 3],
}

impl Tracking {
    /// True when nothing but the tip is tracked.
    pub fn is_default(&self) -> bool {
        *self == Tracking::default()
    }

    /// Names of the points, in order.
    pub fn names(&self) -> Vec<String> {
        self.points.keys().cloned().collect()
    }

    /// Places of all that is tracked.
    pub(crate) fn places(&self) -> TrackedPlaces {
        TrackedPlaces { tip: self.tip, points: self.points.values().copied().collect() }
    }

    /// Refuses points that are not on a backbone of `length_m`.
    ///
    /// # Errors
    /// The path of the key (such as `tracking.points.p1`) and the range that it left.
    pub fn check(&self, length_m: f64) -> Result<(), (String, BadOption)> {
        let refuse = |path: &str, key, found: String, expected| {
            Err((path.to_owned(), BadOption { key, found, expected }))
        };
        if self.points.len() > MAX_POINTS {
            return refuse(
                "tracking",
                "points",
                self.points.len().to_string(),
                "up to 1000 points",
            );
        }
        for (name, point) in &self.points {
            if !is_name(name) {
                return refuse(
                    "tracking",
                    "points",
                    format!("`{name}`"),
                    "a name of letters, digits, `_` and `-`",
                );
            }
            point.check(length_m).map_err(|error| (format!("tracking.points.{name}"), error))?;
        }
        let tip = self.tip.map_or(Ok(()), |tip| tip.check(length_m));
        tip.map_err(|error| ("tracking.tip".to_owned(), error))?;
        let Some(rested_s) = self.rested_s else { return Ok(()) };
        if !(rested_s >= 0.0 && rested_s.is_finite()) {
            return refuse("tracking", "rested_s", rested_s.to_string(), "0 or more seconds");
        }
        if self.starts != Starts::Home {
            let expected = "no such key unless trials start at home (`starts: home`)";
            return refuse("tracking", "rested_s", rested_s.to_string(), expected);
        }
        Ok(())
    }
}

/// Whether columns of a recording and paths of parameters can hold this name.
pub(crate) fn is_name(name: &str) -> bool {
    !name.is_empty()
        && name
            .chars()
            .all(|letter| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-')
}

impl BodyPoint {
    fn check(&self, length_m: f64) -> Result<(), BadOption> {
        BadOption::unless_within(
            "s_m",
            self.s_m,
            0.0..=length_m,
            "a place on the backbone: 0 to its `length_m`",
        )?;
        BadOption::unless_all_finite("offset_m", &self.offset_m)
    }

    /// Position in metres and orientation on the rod, world frame.
    fn pose(&self, rod: &Rod) -> MeasuredPose {
        let (position, turn) = rod.pose_at(self.s_m);
        (position + turn * Vector3::from(self.offset_m), turn)
    }
}

/// Position in metres and orientation.
pub(crate) type MeasuredPose = (Vector3<f64>, Matrix3<f64>);

/// Places of all that is tracked on one rod.
#[derive(Clone, Debug)]
pub(crate) struct TrackedPlaces {
    tip: Option<BodyPoint>,
    points: Vec<BodyPoint>,
}

impl TrackedPlaces {
    /// Pose of the tip, world frame.
    pub(crate) fn tip(&self, rod: &Rod) -> MeasuredPose {
        self.tip.map_or_else(|| (rod.tip_m(), rod.tip_rotation()), |tip| tip.pose(rod))
    }

    /// Poses of the further points, in the order of their names, world frame.
    pub(crate) fn points(&self, rod: &Rod) -> Vec<MeasuredPose> {
        self.points.iter().map(|point| point.pose(rod)).collect()
    }
}

/// A pose as a tracker sees it.
pub(crate) fn seen_point((position, turn): MeasuredPose) -> SeenPoint {
    SeenPoint { position_m: position.into(), quaternion: Some(rotation::to_quaternion(&turn)) }
}
