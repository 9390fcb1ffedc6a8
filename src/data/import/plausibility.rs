//! What an import can see of a mistake without a model: a robot that lies along another axis, a
//! base that moves, bodies that are exchanged, clocks that are apart.

use nalgebra::{Matrix3, Vector3};

use super::Axes;
use crate::base::Point3;
use crate::data::{Actuation, Recording};
use crate::math::summary::quantile;

/// Angle between the tip at home and the z axis above which the axes are in doubt, degrees. A soft
/// robot sags by less.
const MAX_HOME_ANGLE_DEG: f64 = 60.0;
/// Above this angle the base's position is in doubt if the tip never moves as far as it is aside.
const MAX_STIFF_ANGLE_DEG: f64 = 30.0;
/// First commands of trials above this share of the largest command are not at home.
const MAX_START_SHARE: f64 = 0.25;
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
    /// Distance of the tip from the z axis at the start of the trials, and the farthest that it
    /// moves from there, metres, when a stiff robot cannot be so far aside.
    pub aside_m: Option<[f64; 2]>,
    /// The largest displacement in the first row of a trial, metres, with its row and its tendon,
    /// when it is not near home.
    pub away_at_start: Option<(f64, usize, usize)>,
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
    let starts: Vec<usize> = recording.trials().into_iter().map(|(_, range)| range.start).collect();
    let tips = recording.tip_m.as_deref().unwrap_or_default();
    let valid = starts.iter().filter(|&&row| recording.is_valid(row));
    let start_m = median(&valid.map(|&row| tips[row]).collect::<Vec<Point3>>());
    let home_m = start_m.filter(|home_m| is_beyond(MAX_HOME_ANGLE_DEG, *home_m));
    let (base_moves, tip_moves) = (farthest(base_m), farthest(tip_world_m));
    ImportDoubts {
        home_m,
        axes: home_m.map(|home_m| axes.then(&turn_along_z(home_m))),
        aside_m: start_m
            .filter(|start_m| home_m.is_none() && is_beyond(MAX_STIFF_ANGLE_DEG, *start_m))
            .and_then(|start_m| aside_m(start_m, tips)),
        away_at_start: away_at_start(recording, &starts),
        base_moves: base_moves.filter(|(away_m, _)| *away_m > MAX_BASE_MOTION_M),
        exchanged: base_moves.zip(tip_moves).is_some_and(|((base_m, _), (tip_m, _))| {
            base_m > MAX_BASE_MOTION_M && base_m > 3.0 * tip_m
        }),
        jumps_m: jumps_m(tip_world_m),
        onset_s,
    }
}

/// Whether a point is farther from the z axis than this angle.
fn is_beyond(angle_deg: f64, point_m: Point3) -> bool {
    let point_m = Vector3::from(point_m);
    point_m.z < point_m.norm() * angle_deg.to_radians().cos()
}

/// Distance of `start_m` from the z axis and the farthest of the `tips` from it, metres, if that is
/// less.
fn aside_m(start_m: Point3, tips: &[Point3]) -> Option<[f64; 2]> {
    let start = Vector3::from(start_m);
    let aside_m = start.xy().norm();
    let moves = tips.iter().map(|tip| (Vector3::from(*tip) - start).norm());
    let moves_m = moves.filter(|length| length.is_finite()).fold(0.0, f64::max);
    (moves_m < aside_m).then_some([aside_m, moves_m])
}

/// The largest displacement in the rows `starts`, metres, with its row and its tendon, if it is a
/// relevant share of the largest of all rows. Tensions at home and poses at rest need not be 0.
fn away_at_start(recording: &Recording, starts: &[usize]) -> Option<(f64, usize, usize)> {
    if recording.actuation != Actuation::Lengths || recording.at_rest.is_some() {
        return None;
    }
    let largest = |rows: &mut dyn Iterator<Item = usize>| {
        let commands = rows.flat_map(|row| {
            let each = recording.commands.row(row).iter().enumerate();
            each.map(move |(tendon, command)| (*command, row, tendon))
        });
        // Of equal ones the first.
        commands.reduce(|a, b| if b.0.abs() > a.0.abs() { b } else { a })
    };
    let (all_m, ..) = largest(&mut (0..recording.len()))?;
    largest(&mut starts.iter().copied())
        .filter(|(command_m, ..)| command_m.abs() > MAX_START_SHARE * all_m.abs())
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

    /// Two trials of a robot whose tip starts at `home_m`, with `pull_m` on tendon 2 at first.
    fn started(home_m: Point3, pull_m: f64) -> ImportDoubts {
        let mut recording = Recording::new(Actuation::Lengths, 2);
        let mut tips_m = Vec::new();
        for row in 0..8 {
            let moved_m = 0.01 * (row % 4) as f64;
            recording.trial.push(row / 4);
            recording.time_s.push((row % 4) as f64);
            recording.commands.push(&[moved_m, pull_m - moved_m]);
            tips_m.push([home_m[0] + moved_m, home_m[1], home_m[2]]);
        }
        recording.tip_m = Some(tips_m.clone());
        doubts(&recording, &Axes::SAME.parse().unwrap(), &[[0.0; 3]; 8], &tips_m, None)
    }

    #[test]
    fn a_base_elsewhere_and_commands_away_from_home_are_doubted() {
        let good = started([-0.02, 0.0, 0.22], 0.001);
        assert_eq!((good.home_m, good.aside_m, good.away_at_start), (None, None, None));
        let aside = started([0.1, 0.35, 0.26], 0.0);
        let [aside_m, moves_m] = aside.aside_m.unwrap();
        assert!((aside_m - 0.364).abs() < 1e-3 && (moves_m - 0.03).abs() < 1e-9);
        assert_eq!(started([0.0, 0.0, 0.22], 0.016).away_at_start, Some((0.016, 0, 1)));
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
