//! Where residuals point to a wall: the start of a search for contact, which small amounts do not lead to.

use nalgebra::Vector3;

use crate::discovery::recording::samples::Samples;

/// Direction of a wall and the distances at which it may stand.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WallHint {
    /// From x towards y, rad.
    pub(crate) azimuth_rad: f64,
    /// From the plane of x and y towards z, rad.
    pub(crate) elevation_rad: f64,
    /// Distances from the origin, metres, the farthest first.
    pub(crate) distances_m: Vec<f64>,
}

/// A residual beyond this multiple of the lower quartile is large: of the lengths of Gaussian vectors 1 % are.
const LARGE: f64 = 3.1;
/// Shares of rows with a large residual between which there are rows without and with contact.
const SHARES: std::ops::Range<f64> = 0.04..0.9;
/// Least length of the mean of large residuals over their mean length.
const MIN_COHERENCE: f64 = 0.6;
/// Distances tried, over that of the farthest tips with a large residual: another part of the robot may touch before its
/// tip does, and the tip of a long robot may reach round an obstacle.
const TRIED: [f64; 9] = [1.4, 1.2, 1.1, 1.0, 0.9, 0.8, 0.65, 0.5, 0.35];
const FARTHEST_QUANTILE: f64 = 0.9;

/// The wall that would push the tips away as the `residual_m` (three values a sample) are; `None` where large residuals
/// are too few, too many or of too many directions.
pub(crate) fn wall_hint(samples: &Samples, residual_m: &[f64]) -> Option<WallHint> {
    let residuals: Vec<Vector3<f64>> = residual_m.chunks_exact(3).map(Vector3::from_column_slice).collect();
    let mut lengths: Vec<f64> = residuals.iter().map(Vector3::norm).collect();
    lengths.sort_by(f64::total_cmp);
    let limit_m = LARGE * lengths.get(lengths.len() / 4)?;
    let large: Vec<usize> = (0..residuals.len()).filter(|&row| residuals[row].norm() > limit_m).collect();
    if !SHARES.contains(&(large.len() as f64 / residuals.len() as f64)) {
        return None;
    }
    let sum: Vector3<f64> = large.iter().map(|&row| residuals[row]).sum();
    let lengths: f64 = large.iter().map(|&row| residuals[row].norm()).sum();
    if sum.norm() < MIN_COHERENCE * lengths {
        return None;
    }
    let towards = -sum.normalize();
    let mut reaches: Vec<f64> =
        large.iter().map(|&row| towards.dot(&Vector3::from(samples.rows[row].position_m))).collect();
    reaches.sort_by(f64::total_cmp);
    let farthest_m = reaches[((reaches.len() - 1) as f64 * FARTHEST_QUANTILE) as usize];
    (farthest_m > 0.0).then(|| WallHint {
        azimuth_rad: towards.y.atan2(towards.x),
        elevation_rad: towards.z.asin(),
        distances_m: TRIED.iter().map(|share| share * farthest_m).collect(),
    })
}
