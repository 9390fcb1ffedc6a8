//! What a tracker follows on the robot's body besides the tip.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::finite;
use crate::base::{BadOption, SeenPoint};
use crate::math::rotation;
use crate::rod::Rod;

/// Upper bound on tracked points.
const MOST_POINTS: usize = 1000;

/// How the robot is tracked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tracking {
    /// Tracked points by name: that of the columns `point_NAME_x_m,point_NAME_y_m,point_NAME_z_m` of a recording.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub points: BTreeMap<String, BodyPoint>,
    /// State at the start of a trial.
    #[serde(default, skip_serializing_if = "Starts::is_default")]
    pub starts: Starts,
}

/// State at the start of a trial.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Starts {
    /// At rest at home, all displacements 0.
    #[default]
    Home,
    /// At rest under the first command of the trial, without memory of what was before.
    Anywhere,
    /// As the trial before has left it, at rest under its last command; the first trial starts at home.
    Continue,
}

impl Starts {
    fn is_default(&self) -> bool {
        *self == Starts::default()
    }

    /// What it means, as a sentence for the user; none for the default.
    pub fn told(self) -> Option<&'static str> {
        match self {
            Starts::Home => None,
            Starts::Anywhere => Some("Each trial starts at rest under its first command (starts: anywhere)."),
            Starts::Continue => {
                Some("Each trial goes on from the state in which the one before ended (starts: continue).")
            }
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

    /// Places of the points, in the order of their names.
    pub(super) fn places(&self) -> Vec<BodyPoint> {
        self.points.values().copied().collect()
    }

    /// Refuses points that are not on a backbone of `length_m`.
    ///
    /// # Errors
    /// The path of the key (such as `tracking.points.p1`) and the range that it left.
    pub fn check(&self, length_m: f64) -> Result<(), (String, BadOption)> {
        let refuse =
            |path: &str, key, found: String, expected| Err((path.to_owned(), BadOption { key, found, expected }));
        if self.points.len() > MOST_POINTS {
            return refuse("tracking", "points", self.points.len().to_string(), "up to 1000 points");
        }
        for (name, point) in &self.points {
            if !is_name(name) {
                return refuse("tracking", "points", format!("`{name}`"), "a name of letters, digits, `_` and `-`");
            }
            let path = format!("tracking.points.{name}");
            if !(point.s_m >= 0.0 && point.s_m <= length_m) {
                return refuse(&path, "s_m", point.s_m.to_string(), "a place on the backbone: 0 to its `length_m`");
            }
            point.offset_m.iter().try_for_each(|&x| finite("offset_m", x)).map_err(|error| (path, error))?;
        }
        Ok(())
    }
}

/// Whether columns of a recording and paths of parameters can hold this name.
pub(super) fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-')
}

impl BodyPoint {
    /// Position and orientation on the rod, world frame.
    pub(super) fn on(&self, rod: &Rod) -> SeenPoint {
        let (position, turn) = rod.pose_at(self.s_m);
        let position_m = (position + turn * Vector3::from(self.offset_m)).into();
        SeenPoint { position_m, quaternion: Some(rotation::to_quaternion(&turn)) }
    }
}
