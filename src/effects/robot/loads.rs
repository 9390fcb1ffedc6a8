//! Constant loads on a robot, besides weight.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::refuse;
use crate::base::BadOption;
use crate::rod::{LineLoad, PointLoad, RodParams};

/// A constant load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// At one place.
    Point(OnePlace),
    /// Spread evenly over part of the backbone.
    Line(Spread),
}

/// A force and a moment on one cross-section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OnePlace {
    /// Distance from the base along the relaxed backbone, metres.
    pub position_m: f64,
    /// Force, N.
    #[serde(default)]
    pub force_n: [f64; 3],
    /// Moment, N m.
    #[serde(default)]
    pub moment_nm: [f64; 3],
    /// Axes that force and moment are given in.
    #[serde(default)]
    pub frame: Frame,
}

/// Axes that a load is given in.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// The world's: the load keeps its direction (a dead load).
    #[default]
    World,
    /// The cross-section's: the load turns with it (a follower load).
    Body,
}

/// A force per length, in the world frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Start of the load, metres from the base along the relaxed backbone.
    #[serde(default)]
    pub start_m: f64,
    /// End of the load; default: the tip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_m: Option<f64>,
    /// Force per relaxed length, N/m.
    pub force_n_m: [f64; 3],
}

impl Load {
    /// Its name in YAML.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Load::Point(_) => "point",
            Load::Line(_) => "line",
        }
    }

    /// Refuses a load that is not on a backbone of `length_m`.
    pub(super) fn check(&self, length_m: f64) -> Result<(), BadOption> {
        let on_it = "a place on the backbone";
        match self {
            Load::Point(load) => {
                let inside = (0.0..=length_m).contains(&load.position_m);
                refuse(inside, "position_m", &load.position_m, on_it)?;
                BadOption::unless_all_finite("force_n", &load.force_n)?;
                BadOption::unless_all_finite("moment_nm", &load.moment_nm)
            }
            Load::Line(load) => {
                refuse((0.0..=length_m).contains(&load.start_m), "start_m", &load.start_m, on_it)?;
                let end_m = load.end_m.unwrap_or(length_m);
                let beyond = end_m > load.start_m && end_m <= length_m;
                refuse(beyond, "end_m", &end_m, "a place on the backbone beyond `start_m`")?;
                BadOption::unless_all_finite("force_n_m", &load.force_n_m)
            }
        }
    }

    /// Puts the load on a rod.
    pub(super) fn apply(&self, rod: &mut RodParams) {
        match self {
            Load::Point(load) => rod.point_loads.push(PointLoad {
                position_m: load.position_m,
                force_n: Vector3::from(load.force_n),
                moment_nm: Vector3::from(load.moment_nm),
                follows: load.frame == Frame::Body,
            }),
            Load::Line(load) => rod.line_loads.push(LineLoad {
                start_m: load.start_m,
                end_m: load.end_m.unwrap_or(rod.length_m()),
                force_n_m: Vector3::from(load.force_n_m),
            }),
        }
    }
}
