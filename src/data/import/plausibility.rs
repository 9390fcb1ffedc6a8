//! What an import can see of a mistake without a model: a robot that lies along another axis, a
//! base that moves, bodies that are exchanged, clocks that are apart.

use nalgebra::{Matrix3, Vector3};

use super::Axes;
use crate::base::Point3;
use crate::data::Recording;
use crate::math::summary::quantile;

/// Angle between the tip at home and the z axis above which the axes are in doubt, degrees. A soft
/// robot sags by less.
const MAX_HOME_ANGLE_DEG: f64 = 60.0;
/// Motion of the base body that is no noise, metres.
const MAX_BASE_MOTION_M: f64 = 3e-3;
/// Share of the tip's distance by which the tip must sag to show which way is down.
const MIN_SAG_SHARE: f64 = 0.02;

/// What looks like a mistake.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportDoubts {
    /// The tip at the start of the trials, metres, when it is not along z.
    pub home_m: Option<Point3>,
    /// The axes with which it would be along z, and hang down where it sags.
    pub axes: Option<Axes>,
    /// Largest distance of the base body from its median position, metres, with its row, when it
    /// moves.
    pub base_moves: Option<(f64, usize)>,
    /// Whether the base body moves more than the tip body, as when the two are exchanged.
    pub exchanged: bool,
    /// Smallest step of the tip from frame to frame, metres, when it comes back after a few frames
    /// each time, as when the rows of several bodies are taken for one.
    pub jumps_m: Option<f64>,
    /// Time from a command to the first motion of the tip because of it, seconds; none where that
    /// cannot be told.
    pub onset_s: Option<f64>,
}

/// Looks for mistakes in an imported `recording` in `axes`. `base_m`, `tip_world_m`: positions of
/// the base body in each row and of the tip body in each frame, in the tracker's frame.
pub(super) fn doubts(
    recording: &Recording,
    axes: &Axes,
    base_m: &[Point3],
    tip_world_m: &[Point3],
    onset_s: Option<f64>,
) -> ImportDoubts {
    let starts = recording.trials().into_iter().map(|(_, range)| range.start);
    let tips = recording.tip_m.as_deref().unwrap_or_default();
    let home_m = median(
        &starts
            .filter(|&row| recording.is_valid(row))
            .map(|row| tips[row])
            .collect::<Vec<Point3>>(),
    );
    let home_m = home_m.filter(|home| {
        let home = Vector3::from(*home);
        home.z < home.norm() * MAX_HOME_ANGLE_DEG.to_radians().cos()
    });
    let (base_moves, tip_moves) = (farthest(base_m), farthest(tip_world_m));
    ImportDoubts {
        home_m,
        axes: home_m.map(|home_m| axes.then(&turn_along_z(home_m))),
        base_moves: base_moves.filter(|(away_m, _)| *away_m > MAX_BASE_MOTION_M),
        exchanged: base_moves.zip(tip_moves).is_some_and(|((base_m, _), (tip_m, _))| {
            base_m > MAX_BASE_MOTION_M && base_m > 3.0 * tip_m
        }),
        jumps_m: jumps_m(tip_world_m),
        onset_s,
    }
}

/// The step from frame to frame that nearly all frames exceed, metres, where frames that lie a few
/// apart are much closer to each other: rows of several bodies that follow one another.
fn jumps_m(tip_world_m: &[Point3]) -> Option<f64> {
    /// Steps that are no noise, metres.
    const MIN_STEP_M: f64 = 2e-3;
    /// Bodies that follow one another, at most.
    const MAX_BODIES: usize = 12;
    /// So many rounds are needed to tell.
    const MIN_ROUNDS: usize = 4;
    let apart = |frames: usize, share: f64| {
        let pairs = tip_world_m.iter().zip(tip_world_m.iter().skip(frames));
        let lengths = pairs.map(|(a, b)| (Vector3::from(*b) - Vector3::from(*a)).norm());
        quantile(&lengths.filter(|length| length.is_finite()).collect::<Vec<f64>>(), share)
    };
    let enough = |bodies: usize| tip_world_m.len() >= MIN_ROUNDS * bodies;
    if !enough(2) {
        return None;
    }
    let step_m = apart(1, 0.1);
    let comes_back = |bodies: usize| enough(bodies) && 3.0 * apart(bodies, 0.9) < step_m;
    (step_m > MIN_STEP_M && (2..=MAX_BODIES).any(comes_back)).then_some(step_m)
}

/// The quarter turn that lays `home_m` most along z and, if it sags, down along −x; otherwise the
/// smallest such turn.
fn turn_along_z(home_m: Point3) -> Matrix3<f64> {
    let home = Vector3::from(home_m);
    let score = |turn: &Matrix3<f64>| {
        let turned = turn * home;
        let sag = turned.xy().norm() > MIN_SAG_SHARE * home.norm();
        // Weights, so that z decides before the sag, and the sag before the size of the turn.
        4.0 * turned.z + if sag { -turned.x } else { 0.0 } + 1e-6 * home.norm() * turn.trace()
    };
    let turns = quarter_turns();
    let best = turns.into_iter().max_by(|a, b| score(a).total_cmp(&score(b)));
    best.unwrap_or_else(Matrix3::identity)
}

/// The 24 rotations by quarter turns.
fn quarter_turns() -> Vec<Matrix3<f64>> {
    let mut turns = Vec::new();
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        for signs in 0..8_u8 {
            let sign = |axis: usize| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
            let turn =
                Matrix3::from_fn(|row, column| if order[row] == column { sign(row) } else { 0.0 });
            if turn.determinant() > 0.0 {
                turns.push(turn);
            }
        }
    }
    turns
}

/// The farthest finite point from the median, with its index.
fn farthest(points_m: &[Point3]) -> Option<(f64, usize)> {
    let middle = median(points_m)?;
    let away_m = |point: &Point3| (Vector3::from(*point) - Vector3::from(middle)).norm();
    let distances = points_m.iter().enumerate().map(|(index, point)| (away_m(point), index));
    distances.filter(|(away_m, _)| away_m.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The median of each coordinate of the finite points.
fn median(points_m: &[Point3]) -> Option<Point3> {
    let finite: Vec<&Point3> =
        points_m.iter().filter(|point| point.iter().all(|x| x.is_finite())).collect();
    let middle =
        |axis: usize| quantile(&finite.iter().map(|point| point[axis]).collect::<Vec<f64>>(), 0.5);
    (!finite.is_empty()).then(|| std::array::from_fn(middle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_several_bodies_are_jumps_and_a_fast_robot_is_none() {
        let tip = |k: usize| [0.02 * (0.3 * k as f64).sin(), 0.0, 0.22];
        let row = |k: usize| [tip(k), [0.0, 0.0, 0.0], [0.0, 0.01, 0.1]][k % 3];
        let jumps = jumps_m(&(0..60).map(row).collect::<Vec<Point3>>()).unwrap();
        assert!((0.09..0.23).contains(&jumps), "{jumps}");
        assert_eq!(jumps_m(&(0..60).map(tip).collect::<Vec<Point3>>()), None);
        // Random steps of 20 mm at the rate of the frames.
        let wild = |k: usize| [0.02 * (k as f64 * k as f64).sin(), 0.0, 0.22];
        assert_eq!(jumps_m(&(0..60).map(wild).collect::<Vec<Point3>>()), None);
        assert_eq!(jumps_m(&(0..5).map(row).collect::<Vec<Point3>>()), None);
    }

    #[test]
    fn the_turn_lays_the_robot_along_z_and_its_sag_down() {
        // A tracker with z up: the robot along −x, its sag along −z.
        let turn = turn_along_z([-0.218, 0.0005, -0.016]);
        assert_eq!(turn * Vector3::new(-0.218, 0.0, -0.016), Vector3::new(-0.016, 0.0, 0.218));
        // Without a sag the smallest turn.
        assert_eq!(turn_along_z([0.0, 0.2, 0.0]) * Vector3::y(), Vector3::z());
        assert_eq!(turn_along_z([0.001, 0.0, 0.2]), Matrix3::identity());
    }
}
