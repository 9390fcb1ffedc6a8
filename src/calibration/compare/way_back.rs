//! Whether a recording shows memory: at equal commands the way back lies elsewhere than the way out.

use nalgebra::DVector;

use super::comparison::Comparison;
use crate::base::{Point3, distance_m};
use crate::math::distribution::normal_above;
use crate::math::summary::rank_correlation;

/// Rows this near in time are no return.
const MIN_ROWS_APART: usize = 5;
/// Cosine between two motions beyond which they go the same way, or back.
const SAME_WAY: f64 = 0.5;
/// Chance of a difference where there is none, and fewest pairs of rows that show one.
const CHANCE: f64 = 1e-3;
const MIN_PAIRS: usize = 20;

/// A compared row: command, motion of the command up to it, and first tracked point.
struct Visit {
    row: usize,
    /// Weight hung on purpose.
    hung_kg: f64,
    command: DVector<f64>,
    motion: DVector<f64>,
    at_m: Point3,
}

/// Whether points are farther apart where rows of like commands were reached from opposite sides
/// than where they were reached from the same side (rank-sum test, Mann & Whitney 1947).
pub(crate) fn way_back_differs(comparison: &Comparison) -> bool {
    let visits = visits(comparison);
    let (mut is_return, mut apart_m) = (Vec::new(), Vec::new());
    for visit in &visits {
        // The other visit at the most similar command.
        let others = visits.iter().filter(|other| {
            other.row.abs_diff(visit.row) > MIN_ROWS_APART && other.hung_kg == visit.hung_kg
        });
        let nearest = others
            .map(|other| (other.command.metric_distance(&visit.command), other))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((away, other)) = nearest.filter(|(away, _)| *away <= visit.motion.norm()) else {
            continue;
        };
        let cosine = visit.motion.dot(&other.motion)
            / (visit.motion.norm() * other.motion.norm()).max(f64::MIN_POSITIVE);
        if cosine.abs() > SAME_WAY && away.is_finite() {
            is_return.push(f64::from(u8::from(cosine < 0.0)));
            apart_m.push(distance_m(&visit.at_m, &other.at_m));
        }
    }
    let returns: f64 = is_return.iter().sum();
    if returns < MIN_PAIRS as f64 || (is_return.len() as f64 - returns) < MIN_PAIRS as f64 {
        return false;
    }
    // With one variable of two values the rank correlation is the rank-sum statistic.
    let deviations = rank_correlation(&is_return, &apart_m) * (is_return.len() as f64 - 1.0).sqrt();
    normal_above(deviations) < CHANCE
}

fn visits(comparison: &Comparison) -> Vec<Visit> {
    let recording = &comparison.recordings.joined;
    let seen = comparison.sightings.iter().filter(|sighting| {
        let row = sighting.row;
        sighting.marker == 0 && row > 0 && recording.trial[row - 1] == recording.trial[row]
    });
    seen.map(|sighting| {
        let command_of = |row: usize| DVector::from_column_slice(recording.commands.row(row));
        let command = command_of(sighting.row);
        let motion = &command - command_of(sighting.row - 1);
        let hung_kg = recording.known_load_kg.as_ref().map_or(0.0, |all| all[sighting.row]);
        Visit { row: sighting.row, hung_kg, command, motion, at_m: sighting.at_m }
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Actuation, Recording};
    use crate::effects::Model;

    /// Pulls out and back; on the way back the tip lies `lag_m` farther out. Places scatter by 1 mm.
    fn differs(lag_m: f64) -> bool {
        let mut recording = Recording::new(Actuation::Lengths, 4);
        let mut tips = Vec::new();
        for row in 0..400_u32 {
            let (way, step) = (row / 20, row % 20);
            let pull_m = 5e-4 * f64::from(if way % 2 == 0 { step } else { 20 - step });
            recording.trial.push(0);
            recording.time_s.push(f64::from(row));
            recording.commands.push(&[pull_m, 0.0, -pull_m, 0.0]);
            let scatter_m = 1e-3 * f64::from(row * 7919 % 101) / 101.0;
            tips.push([3.0 * pull_m + scatter_m + f64::from(way % 2) * lag_m, 0.0, 0.2]);
        }
        recording.tip_m = Some(tips);
        way_back_differs(&Comparison::new(&Model::default(), &recording.into(), true).unwrap())
    }

    #[test]
    fn a_loop_is_told_from_scatter() {
        assert!(differs(2e-3) && !differs(0.0));
    }
}
