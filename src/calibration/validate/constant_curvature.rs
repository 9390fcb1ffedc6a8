//! Piecewise constant curvature (Webster & Jones 2010) with fitted gains, the usual model of a
//! laboratory without a rod: each segment is an arc whose bending is proportional to the mean
//! displacement (or tension) of its tendons along their angles.

use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector2, Vector3};

use crate::base::Point3;
use crate::calibration::compare::blocks::SightingSplit;
use crate::calibration::compare::comparison::Comparison;
use crate::data::Actuation;
use crate::effects::Model;
use crate::math::optimise::least_squares;
use crate::plants::{ConstantCurvature, ConstantCurvatureOptions};

/// Step for differences: rounding of a closed formula.
const STEP: f64 = 1e-6;
/// Numbers of the base pose, and of each segment: gain, turn, two bends at zero.
const POSE: usize = 6;
const OF_SEGMENT: usize = 4;
/// Rows to which it is fitted at most.
const MAX_ROWS: usize = 600;

/// The robot as arcs.
struct Arcs {
    /// Length of each segment, metres.
    lengths_m: Vec<f64>,
    /// Segment in which each tendon ends, and its direction.
    tendons: Vec<(usize, Vector2<f64>)>,
    /// Bending per mean displacement, or per mean tension, to start from.
    gain: f64,
    tensions: bool,
    /// Distance of each tracked point from the base, metres.
    places_m: Vec<f64>,
    base_m: Vector3<f64>,
    base_rotation_rad: Vector3<f64>,
}

/// Predictions of the unseen sightings after a fit to the others, and the number of fitted numbers.
pub(crate) fn predictions(
    model: &Model,
    comparison: &Comparison,
    commands: &[Vec<f64>],
    SightingSplit { fitted, unseen }: SightingSplit,
) -> Option<(Vec<Point3>, usize)> {
    let arcs = Arcs::new(model, comparison)?;
    let count = POSE + OF_SEGMENT * arcs.lengths_m.len();
    let step = fitted.len().div_ceil(MAX_ROWS).max(1);
    let rows: Vec<usize> = fitted.iter().copied().step_by(step).collect();
    let at = |parameters: &[f64], index: usize| {
        let sighting = comparison.sightings[index];
        arcs.point_m(parameters, &commands[sighting.row], arcs.places_m[sighting.marker])
    };
    let residuals = |parameters: &[f64]| -> Option<Vec<f64>> {
        let each = rows.iter().flat_map(|&index| {
            let difference =
                at(parameters, index) - Vector3::from(comparison.sightings[index].at_m);
            [difference.x, difference.y, difference.z]
        });
        let all: Vec<f64> = each.collect();
        all.iter().all(|value| value.is_finite()).then_some(all)
    };
    let derivative = |parameters: &[f64]| -> Option<DMatrix<f64>> {
        let shifted = |k: usize, by: f64| {
            let mut moved = parameters.to_vec();
            moved[k] += by;
            residuals(&moved).map(DVector::from_vec)
        };
        let column = |k: usize| Some((shifted(k, STEP)? - shifted(k, -STEP)?) / (2.0 * STEP));
        let columns: Vec<DVector<f64>> = (0..count).map(column).collect::<Option<_>>()?;
        Some(DMatrix::from_columns(&columns))
    };
    let mut start = vec![0.0; count];
    // Unit gains: the textbook's relation between displacement and bending.
    (0..arcs.lengths_m.len()).for_each(|segment| start[POSE + OF_SEGMENT * segment] = 1.0);
    let fit = least_squares::fit(&residuals, &derivative, &start)?;
    Some((unseen.iter().map(|&index| at(&fit.parameters, index).into()).collect(), count))
}

impl Arcs {
    fn new(model: &Model, comparison: &Comparison) -> Option<Arcs> {
        let robot = &model.robot;
        let length_m = robot.backbone.length_m;
        let tendons = &robot.tendons;
        if tendons.angles_deg.len() > comparison.recordings.joined.tendons() {
            return None;
        }
        let end = |i: usize| tendons.ends_m.as_ref().map_or(length_m, |ends| ends[i]);
        let mut ends: Vec<f64> = (0..tendons.angles_deg.len()).map(end).collect();
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| (*a - *b).abs() < 1e-3 * length_m);
        // What is left beyond the last tendon stays straight, and is part of no segment's bending.
        let starts = std::iter::once(0.0).chain(ends.iter().copied());
        let lengths_m: Vec<f64> = ends.iter().zip(starts).map(|(end, start)| end - start).collect();
        let segment = |i: usize| {
            let nearest = |a: &&f64, b: &&f64| (*a - end(i)).abs().total_cmp(&(*b - end(i)).abs());
            let at = ends
                .iter()
                .min_by(nearest)
                .and_then(|nearest| ends.iter().position(|end| end == nearest));
            let angle = tendons.angles_deg[i].to_radians();
            at.map(|at| (at, Vector2::new(angle.cos(), angle.sin())))
        };
        let tensions = comparison.recordings.joined.actuation == Actuation::Tensions;
        let radius_m = tendons.radius_m;
        let stiffness = robot.rod().spans.first().map_or(1.0, |span| span.bending_n_m2[0]);
        let gain = if tensions { radius_m * length_m / stiffness } else { 1.0 / radius_m };
        Some(Arcs {
            tendons: (0..tendons.angles_deg.len()).map(segment).collect::<Option<_>>()?,
            lengths_m,
            gain,
            tensions,
            places_m: comparison.markers.iter().map(|name| place_m(model, name)).collect(),
            base_m: Vector3::from(robot.base_m),
            base_rotation_rad: Vector3::from(robot.base_rotation_rad),
        })
    }

    /// Position of a point `place_m` from the base, metres.
    fn point_m(&self, parameters: &[f64], command: &[f64], place_m: f64) -> Vector3<f64> {
        let count = self.lengths_m.len();
        let mut pull = vec![Vector2::zeros(); count];
        let mut holes = vec![0.0; count];
        for (&(segment, direction), value) in self.tendons.iter().zip(command) {
            pull[segment] += *value * direction;
            // Σ cos² over evenly spread tendons is half their number.
            holes[segment] += 0.5;
        }
        let angles_rad: Vec<Vector2<f64>> = pull
            .iter()
            .zip(&holes)
            .map(|(pull, holes): (&Vector2<f64>, &f64)| pull * (self.gain / holes.max(0.5)))
            .collect();
        let vector =
            |at: usize| Vector3::new(parameters[at], parameters[at + 1], parameters[at + 2]);
        let mut at = self.base_m + vector(0) * self.lengths_m.iter().sum::<f64>();
        let mut turn = UnitQuaternion::from_scaled_axis(self.base_rotation_rad)
            * UnitQuaternion::from_scaled_axis(vector(3));
        let (mut start_m, mut bent) = (0.0, Vector2::zeros());
        for segment in 0..count {
            let numbers =
                &parameters[POSE + OF_SEGMENT * segment..POSE + OF_SEGMENT * (segment + 1)];
            // Displacement: what earlier segments took is not left for this one. Tension: all that
            // end further on bend it.
            let commanded = if self.tensions {
                angles_rad[segment..].iter().sum()
            } else {
                angles_rad[segment] - bent
            };
            let (sin, cos) = numbers[1].sin_cos();
            let bend = numbers[0]
                * Vector2::new(
                    cos * commanded.x - sin * commanded.y,
                    sin * commanded.x + cos * commanded.y,
                )
                + Vector2::new(numbers[2], numbers[3]);
            let last = segment + 1 == count;
            // Beyond the last segment the robot is straight, along the tangent.
            let share = ((place_m - start_m) / self.lengths_m[segment])
                .clamp(0.0, if last { f64::INFINITY } else { 1.0 });
            let arc = ConstantCurvatureOptions {
                length_m: share * self.lengths_m[segment],
                ..Default::default()
            };
            at += turn * Vector3::from(ConstantCurvature::tip_m(&arc, (share * bend).into()));
            turn *= UnitQuaternion::from_scaled_axis(Vector3::new(-bend.y, bend.x, 0.0));
            bent += bend;
            start_m += self.lengths_m[segment];
            if place_m <= start_m {
                break;
            }
        }
        at
    }
}

/// Where a tracked point sits, metres from the base.
fn place_m(model: &Model, name: &str) -> f64 {
    model.tracking.points.get(name).map_or(model.robot.backbone.length_m, |point| point.s_m)
}
