//! The surface of a rod that touches obstacles.

use super::obstacle::Obstacle;

/// What a rod touches, and with which surface: a tube around the backbone, closed by a hemisphere
/// at the tip, wider where there are disks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactSurface {
    /// Fixed obstacles; without any there is no contact.
    pub obstacles: Vec<Obstacle>,
    /// Radius of the tube, metres.
    pub radius_m: f64,
    /// Where the rod is wider.
    pub disks: Vec<DiskSurface>,
}

/// A part of the rod whose surface is farther from the backbone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskSurface {
    /// Where it begins, metres from the base along the relaxed rod.
    pub start_m: f64,
    /// Where it ends.
    pub end_m: f64,
    /// Its radius, metres.
    pub radius_m: f64,
}

/// Slack of the ends of a disk, metres: one of no thickness lies at the end of a cell.
const SAME_PLACE_M: f64 = 1e-9;

impl ContactSurface {
    /// Distance of the surface from the backbone at `position_m`, metres.
    pub fn radius_at(&self, position_m: f64) -> f64 {
        let covers = |disk: &&DiskSurface| {
            position_m >= disk.start_m - SAME_PLACE_M && position_m <= disk.end_m + SAME_PLACE_M
        };
        self.disks.iter().filter(covers).map(|disk| disk.radius_m).fold(self.radius_m, f64::max)
    }

    /// Whether an obstacle has friction.
    pub(crate) fn has_friction(&self) -> bool {
        self.obstacles.iter().any(|obstacle| obstacle.friction_coefficient > 0.0)
    }
}
