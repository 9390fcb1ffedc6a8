//! Pose of the robot's base frame in the base body's frame, from points known in both.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::fault::TrackingFault;
use super::pose::RigidPose;
use crate::base::Point3;

/// Points count as collinear if their spread across the longest direction is below this share of
/// the spread along it.
const THINNEST: f64 = 0.02;

/// Standard normal quantile of a two-sided 95 % interval.
const NORMAL_95: f64 = 1.96;

/// Larger coordinates are not lengths in metres.
const LARGEST_M: f64 = 1000.0;

/// The pose found, and its quality of fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Pose of the robot's base frame in the base body's frame: the setting `alignment`.
    pub pose: RigidPose,
    /// Root mean square of the residual distances, metres.
    pub residual_m: f64,
    /// Largest of them, metres.
    pub worst_m: f64,
    /// Root mean square of the distances of the points from their centre, metres.
    pub spread_m: f64,
    /// Half width of the 95 % interval of the rotation about its least determined axis, radians, if
    /// the residuals are noise.
    pub turn_rad: f64,
    /// How many times as far as predicted the points are from their centre, across the robot.
    pub ratio: f64,
    /// Root mean square of the angles between measured and predicted directions across the robot,
    /// radians, weighted by their lengths.
    pub apart_rad: f64,
    /// Correlation of measured and predicted coordinates along the robot: negative for a mirror
    /// image.
    pub upright: f64,
    /// As `pose`, with the shift of the point nearest to the robot's axis, which does not depend on
    /// how far the robot bends.
    pub straight_pose: RigidPose,
}

/// Largest root mean square of the angles between directions that agree, radians: 10°.
const MAX_APART_RAD: f64 = 0.175;
/// Smallest correlation along the robot of points that are no mirror image.
const MIN_UPRIGHT: f64 = 0.5;
/// Ratios that are a wrong stiffness or radius of the model, rather than another body or unit.
const BEND_RATIOS: [f64; 2] = [0.4, 2.5];

impl Alignment {
    /// True if the directions of the points agree, however far they are.
    pub fn directions_agree(&self) -> bool {
        let sized = (BEND_RATIOS[0]..=BEND_RATIOS[1]).contains(&self.ratio);
        sized && self.apart_rad <= MAX_APART_RAD && self.upright >= MIN_UPRIGHT
    }
}

/// [`align`] for points measured with the alignment `present`: the alignment to replace it.
///
/// # Errors
/// As [`align`].
pub fn realign(
    present: &RigidPose,
    robot_m: &[Point3],
    measured_m: &[Point3],
) -> Result<Alignment, TrackingFault> {
    let motion = present.motion();
    let body = |point: &Point3| (motion * nalgebra::Point3::from(*point)).coords.into();
    align(robot_m, &measured_m.iter().map(body).collect::<Vec<Point3>>())
}

/// The rigid motion that brings the points `robot_m` in the robot's base frame closest to the same
/// points `body_m`, measured with an `alignment` of identity (Kabsch's method, without scale).
///
/// # Errors
/// [`TrackingFault::Alignment`] for fewer than three points, values that are not lengths, or
/// collinear points.
pub fn align(robot_m: &[Point3], body_m: &[Point3]) -> Result<Alignment, TrackingFault> {
    let refuse = |why: String| Err(TrackingFault::Alignment(why));
    if robot_m.len() != body_m.len() {
        return refuse(format!(
            "{} points in the robot's frame and {} measured",
            robot_m.len(),
            body_m.len()
        ));
    }
    if robot_m.len() < 3 {
        return refuse(format!(
            "{} points, expected at least 3, better 10 distributed over the workspace",
            robot_m.len()
        ));
    }
    if robot_m
        .iter()
        .chain(body_m)
        .flatten()
        .any(|value| !value.is_finite() || value.abs() > LARGEST_M)
    {
        return refuse(format!("a coordinate is not a number within ±{LARGEST_M} m"));
    }
    let (robot, robot_centre) = centred(robot_m);
    let (body, body_centre) = centred(body_m);
    for (points, whose) in [(&robot, "the robot's points"), (&body, "the measured points")] {
        let thinness = thinness(points);
        if thinness < THINNEST {
            let expected = "bend the robot in at least two directions";
            return refuse(format!(
                "{whose} lie on a line (ratio of width to length {thinness:.4}, expected at least \
                 {THINNEST}); {expected}"
            ));
        }
    }
    // 1. Rotation between centred points; 2. the shift that brings the centres together.
    let turn = turn_between(&robot, &body);
    let shift = body_centre - turn * robot_centre;
    let motion = Isometry3::from_parts(shift.into(), UnitQuaternion::from_rotation_matrix(&turn));
    let squares: Vec<f64> =
        robot.iter().zip(&body).map(|(from, to)| (turn * from - to).norm_squared()).collect();
    let residual_m = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let worst_m = squares.iter().copied().fold(0.0, f64::max).sqrt();
    let count = robot.len() as f64;
    let spread_m = (robot.iter().map(|point| point.norm_squared()).sum::<f64>() / count).sqrt();
    // About the axis of the largest spread, only the other two spreads determine the rotation; six
    // numbers are fitted.
    let [smallest, middle, _] = spreads(&robot);
    let freedom = (3.0 * count - 6.0).max(1.0);
    let noise_variance_m2 = squares.iter().sum::<f64>() / freedom;
    let turn_rad = NORMAL_95 * (noise_variance_m2 / (smallest + middle)).sqrt();
    let turned: Vec<Vector3<f64>> = robot.iter().map(|point| turn * point).collect();
    let Bends { ratio, apart_rad, upright, straightest } = compare_bends(&turned, &body);
    let straight_shift =
        body[straightest] + body_centre - turn * (robot[straightest] + robot_centre);
    let straight = Isometry3::from_parts(straight_shift.into(), motion.rotation);
    let (pose, straight_pose) = (RigidPose::of(&motion), RigidPose::of(&straight));
    Ok(Alignment {
        pose,
        residual_m,
        worst_m,
        spread_m,
        turn_rad,
        ratio,
        apart_rad,
        upright,
        straight_pose,
    })
}

/// Comparison of points that were turned into each other's frame.
struct Bends {
    ratio: f64,
    apart_rad: f64,
    upright: f64,
    /// Index of the predicted point nearest to the centre across the robot.
    straightest: usize,
}

/// Compares centred points across the two directions of their largest spread, and along the third.
fn compare_bends(predicted: &[Vector3<f64>], measured: &[Vector3<f64>]) -> Bends {
    let scatter: Matrix3<f64> = predicted.iter().map(|point| point * point.transpose()).sum();
    let eigen = scatter.symmetric_eigen();
    // A bending tip moves least along the robot: the direction of the smallest spread.
    let along: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
    let across = |point: &Vector3<f64>| point - along * along.dot(point);
    let (mut products, mut squares, mut angles, mut weights) = (0.0, 0.0, 0.0, 0.0);
    let (mut joint, mut predicted_squares, mut measured_squares) = (0.0, 0.0, 0.0);
    for (from, to) in predicted.iter().zip(measured) {
        let (a, b) = (across(from), across(to));
        products += a.dot(&b);
        squares += a.norm_squared();
        let weight = a.norm() * b.norm();
        if weight > 0.0 {
            // Directions of points near the axis are noise, hence the weights.
            angles += weight * a.angle(&b).powi(2);
            weights += weight;
        }
        joint += along.dot(from) * along.dot(to);
        predicted_squares += along.dot(from).powi(2);
        measured_squares += along.dot(to).powi(2);
    }
    let nearest = |a: &usize, b: &usize| {
        across(&predicted[*a]).norm().total_cmp(&across(&predicted[*b]).norm())
    };
    Bends {
        ratio: products / squares,
        apart_rad: if weights > 0.0 { (angles / weights).sqrt() } else { f64::INFINITY },
        upright: if predicted_squares * measured_squares > 0.0 {
            joint / (predicted_squares * measured_squares).sqrt()
        } else {
            0.0
        },
        straightest: (0..predicted.len()).min_by(nearest).unwrap_or(0),
    }
}

fn centred(points_m: &[Point3]) -> (Vec<Vector3<f64>>, Vector3<f64>) {
    let points: Vec<Vector3<f64>> = points_m.iter().map(|point| Vector3::from(*point)).collect();
    let centre = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    (points.iter().map(|point| point - centre).collect(), centre)
}

/// Spread in the second direction over the spread in the first; 0 for a line or a point.
fn thinness(points: &[Vector3<f64>]) -> f64 {
    let [_, middle, largest] = spreads(points);
    if largest > 0.0 { (middle / largest).sqrt() } else { 0.0 }
}

/// Sums of squares along the principal directions, smallest first, square metres.
fn spreads(points: &[Vector3<f64>]) -> [f64; 3] {
    let scatter: Matrix3<f64> = points.iter().map(|point| point * point.transpose()).sum();
    let mut spreads: [f64; 3] = scatter.symmetric_eigenvalues().into();
    spreads.sort_by(f64::total_cmp);
    spreads.map(|spread| spread.max(0.0))
}

/// The rotation that brings `from` closest to `to`.
fn turn_between(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> Rotation3<f64> {
    // Kabsch: the singular vectors of the covariance give the closest orthogonal matrix.
    let covariance: Matrix3<f64> =
        from.iter().zip(to).map(|(from, to)| to * from.transpose()).sum();
    let svd = covariance.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Rotation3::identity() };
    // The closest orthogonal matrix may be a reflection: then the smallest direction is inverted.
    // Singular values are sorted, so it is the last one.
    let handedness = (u * v_t).determinant().signum();
    let turn = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, handedness)) * v_t;
    Rotation3::from_matrix_unchecked(turn)
}
