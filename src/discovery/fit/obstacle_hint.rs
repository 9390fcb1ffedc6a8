//! Where residuals point to an obstacle: the start of a search for contact, which small amounts do
//! not lead to.
//!
//! Without the obstacle the model's body enters it in the rows in which the measured tip was pushed
//! aside, and in no other rows. That is asked of balls and walls at many places, with the shapes of
//! one simulation.

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::base::counted;

/// A ball or a wall beside the axis of the straight robot, as the effect `contact` places it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ObstacleHint {
    /// Direction from the base's x towards its y, rad.
    pub(crate) azimuth_rad: f64,
    /// Place along the axis, metres from the base.
    pub(crate) position_m: f64,
    /// One over the radius, 1/m; 0 for a wall.
    pub(crate) curvature_1_m: f64,
    /// Distances from the axis to be tried, metres, in order.
    pub(crate) distances_m: Vec<f64>,
    /// Cosine between the pushes of this obstacle and the residuals.
    pub(crate) agreement: f64,
}

/// The places of the body that are asked, from base to tip, in one row, and the residual of the tip
/// there, metres; in the frame of the base.
#[derive(Clone, Debug)]
pub(crate) struct BodyRow {
    pub(crate) places_m: Vec<Vector3<f64>>,
    pub(crate) residual_m: Vector3<f64>,
}

/// A residual beyond this multiple of the lower quartile is large: of the lengths of Gaussian
/// vectors 1 % are. The thresholds were set before any recording was tested
/// (docs/method/search.md, "Obstacles").
const LARGE_RATIO: f64 = 3.1;
/// Shares of rows with a large residual between which there are rows without and with contact.
const CONTACT_SHARES: std::ops::Range<f64> = 0.04..0.9;
/// Least agreement of an obstacle that is worth a fit.
const MIN_AGREEMENT: f64 = 0.75;
/// Grid of places, in lengths of the robot.
const DISTANCES: [f64; 9] = [0.01, 0.03, 0.05, 0.08, 0.12, 0.17, 0.23, 0.3, 0.4];
const POSITIONS: [f64; 9] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
const RADII: [f64; 4] = [0.05, 0.1, 0.2, 0.5];
const AZIMUTHS: usize = 24;
/// Best places of the grid that are refined, and how often their steps are halved.
const MAX_REFINED: usize = 8;
const HALVINGS: usize = 5;
/// Distances that are then tried, beside the best one, in lengths.
const DISTANCE_OFFSETS: [f64; 7] = [-0.06, -0.03, -0.015, 0.0, 0.015, 0.03, 0.06];

/// Distance, azimuth, position and curvature in lengths of the robot.
type Place = [f64; 4];

/// The obstacle that agrees best with the residuals of `rows` on a robot of `length_m`; `None`
/// where large residuals are too few or too many, or agree with none.
pub(crate) fn obstacle_hint(rows: &[BodyRow], length_m: f64) -> Option<ObstacleHint> {
    let mut lengths: Vec<f64> = rows.iter().map(|row| row.residual_m.norm()).collect();
    lengths.sort_by(f64::total_cmp);
    // Up to three quarters of the rows may be in contact without raising the lower quartile.
    let limit_m = LARGE_RATIO * lengths.get(lengths.len() / 4)?;
    let large = lengths.iter().filter(|length| **length > limit_m).count();
    if !CONTACT_SHARES.contains(&(large as f64 / lengths.len() as f64)) {
        return None;
    }
    let of = |place: Place| (agreement(rows, length_m, place), place);
    let mut best: Vec<(f64, Place)> = grid().into_par_iter().map(counted(of)).collect();
    best.sort_by(|a, b| b.0.total_cmp(&a.0));
    best.truncate(MAX_REFINED);
    let refined = best.into_par_iter().map(counted(|start| refine(rows, length_m, start)));
    let (agreement, [distance, azimuth, position, curvature]) =
        refined.max_by(|a, b| a.0.total_cmp(&b.0))?;
    if agreement < MIN_AGREEMENT {
        return None;
    }
    let distances_m = DISTANCE_OFFSETS
        .iter()
        .map(|beside| (distance + beside) * length_m)
        .filter(|distance| *distance > 0.0);
    Some(ObstacleHint {
        azimuth_rad: azimuth,
        position_m: position * length_m,
        curvature_1_m: curvature / length_m,
        distances_m: distances_m.collect(),
        agreement,
    })
}

fn grid() -> Vec<Place> {
    let mut places = Vec::new();
    for step in 0..AZIMUTHS {
        let azimuth = std::f64::consts::TAU * step as f64 / AZIMUTHS as f64 - std::f64::consts::PI;
        for distance in DISTANCES {
            // A wall has no place along the robot; 0.5 only fills the slot.
            places.push([distance, azimuth, 0.5, 0.0]);
            for position in POSITIONS {
                places
                    .extend(RADII.iter().map(|radius| [distance, azimuth, position, 1.0 / radius]));
            }
        }
    }
    places
}

/// The best place near `start`, by steps along each number that are halved.
fn refine(rows: &[BodyRow], length_m: f64, start: (f64, Place)) -> (f64, Place) {
    let mut best = start;
    // Half a grid step: the grid has told which cell is best.
    let mut steps = [0.02, 0.13, 0.05, 0.3 * start.1[3]];
    for _ in 0..HALVINGS {
        loop {
            let before = best.0;
            for number in 0..steps.len() {
                for step in [steps[number], -steps[number]] {
                    let mut place = best.1;
                    place[number] += step;
                    let there = agreement(rows, length_m, place);
                    if there > best.0 && place[0] > 0.0 && place[3] >= 0.0 {
                        best = (there, place);
                    }
                }
            }
            if best.0 <= before {
                break;
            }
        }
        steps = steps.map(|step| 0.5 * step);
    }
    best
}

/// Cosine between the residuals and the pushes of an obstacle: along its normal, as far as the body
/// enters it, magnified by the lever to the tip.
fn agreement(
    rows: &[BodyRow],
    length_m: f64,
    [distance, azimuth, position, curvature]: Place,
) -> f64 {
    let outwards = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
    // Infinite for a wall, which the branch below treats by its plane.
    let radius_m = length_m / curvature;
    let center_m =
        outwards * (distance * length_m + radius_m) + Vector3::z() * (position * length_m);
    let (mut product, mut pushed, mut residual) = (0.0, 0.0, 0.0);
    for row in rows {
        let (mut deepest_m, mut push) = (0.0, Vector3::zeros());
        for (k, place_m) in row.places_m.iter().enumerate() {
            let (depth_m, normal) = if curvature == 0.0 {
                (outwards.dot(place_m) - distance * length_m, -outwards)
            } else {
                let arm = place_m - center_m;
                let far_m = arm.norm();
                (radius_m - far_m, arm / far_m)
            };
            // Only the deepest place pushes.
            if depth_m > deepest_m {
                deepest_m = depth_m;
                // A rod that is pushed aside at one place moves its tip by the lever ratio more.
                push = normal * (depth_m * row.places_m.len() as f64 / (k + 1) as f64);
            }
        }
        product += push.dot(&row.residual_m);
        pushed += push.norm_squared();
        residual += row.residual_m.norm_squared();
    }
    if pushed > 0.0 { product / (pushed * residual).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Straight bodies of unit length that lean in all directions, pushed out of a ball.
    fn leaning(ball: Option<(Vector3<f64>, f64)>) -> Vec<BodyRow> {
        let row = |k: usize| {
            let (angle, lean) = (0.7 * k as f64, 0.5 * ((k * 37 % 100) as f64 / 100.0));
            let tip = Vector3::new(lean * angle.cos(), lean * angle.sin(), 1.0);
            let places_m: Vec<Vector3<f64>> =
                (1..=10).map(|k| tip * (f64::from(k) / 10.0)).collect();
            let mut residual_m =
                Vector3::new(1e-3 * (3.0 * angle).sin(), 1e-3 * (5.0 * angle).cos(), 0.0);
            if let Some((center, radius)) = ball {
                for (k, place) in places_m.iter().enumerate() {
                    let arm = place - center;
                    residual_m += arm.normalize()
                        * (radius - arm.norm()).max(0.0)
                        * (10.0 / (k + 1) as f64)
                        * 0.5;
                }
            }
            BodyRow { places_m, residual_m }
        };
        (0..200).map(row).collect()
    }

    #[test]
    fn a_ball_is_found_and_noise_is_none() {
        let (center, radius) = (Vector3::new(0.25, 0.1, 0.7), 0.15);
        let hint = obstacle_hint(&leaning(Some((center, radius))), 1.0).unwrap();
        // Bodies that all lean straight from the base do not tell where along them the ball is.
        assert!(
            hint.agreement > 0.9 && (hint.azimuth_rad - 0.1_f64.atan2(0.25)).abs() < 0.1,
            "{hint:?}"
        );
        assert_eq!(obstacle_hint(&leaning(None), 1.0), None);
    }
}
