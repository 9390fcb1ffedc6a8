//! Bending a robot with any number of tendons. A point (a, b) of the actuation plane of a segment,
//! in metres, is a bend towards the segment's first tendon (a > 0) and a quarter of a turn further
//! (b > 0). The two tendons on both sides of the bend are actuated, "the remaining two tendon
//! lengths" (of the paper's four, section IV-A) follow the shape.

use serde::{Deserialize, Serialize};

use crate::base::{BadOption, Observation, Plant, PlantError, TendonCommand, TendonLayout};

/// Bends of all segments from base to tip, metres: two numbers a segment.
pub(crate) type Bend = Vec<f64>;

/// How the tendons of a robot bend its segments.
#[derive(Clone, Debug, PartialEq)]
pub struct BendMap {
    tendons: usize,
    segments: Vec<SegmentBend>,
}

/// The tendons of a segment, by their angle from its first one.
#[derive(Clone, Debug, PartialEq)]
struct SegmentBend {
    /// Numbers and angles in degrees, ascending from the first tendon.
    tendons: Vec<(usize, f64)>,
    /// Angle of the first tendon from x towards y, degrees.
    first_deg: f64,
}

impl BendMap {
    /// The map of a plant's tendons.
    ///
    /// # Errors
    /// [`PlantError::Refused`] for a segment whose tendons are all on one side.
    pub fn of(plant: &dyn Plant) -> Result<BendMap, PlantError> {
        let layout = plant.tendon_layout();
        layout.check().map_err(|found| {
            PlantError::Refused(format!("{found}, expected tendons on every side"))
        })?;
        Ok(BendMap::new(&layout))
    }

    fn new(layout: &TendonLayout) -> BendMap {
        let segment = |tendons: &Vec<crate::base::PlacedTendon>| {
            let first_deg = tendons.first().map_or(0.0, |placed| placed.angle_deg);
            let mut sorted: Vec<(usize, f64)> = tendons
                .iter()
                .map(|placed| (placed.tendon, (placed.angle_deg - first_deg).rem_euclid(360.0)))
                .collect();
            // `actuated` looks for the neighbours of a direction.
            sorted.sort_by(|left, right| left.1.total_cmp(&right.1));
            SegmentBend { tendons: sorted, first_deg }
        };
        let tendons = layout.segments.iter().map(Vec::len).sum();
        BendMap { tendons, segments: layout.segments.iter().map(segment).collect() }
    }

    /// The straight robot.
    pub(crate) fn straight(&self) -> Bend {
        vec![0.0; 2 * self.segments.len()]
    }

    /// The same bend in every segment.
    pub(crate) fn everywhere(&self, bend_m: [f64; 2]) -> Bend {
        bend_m.repeat(self.segments.len())
    }

    /// The commands for a bend of every segment, metres. No displacement exceeds the largest
    /// component of the bend.
    pub fn commands(&self, bend_m: &[f64]) -> Vec<TendonCommand> {
        let mut commands = vec![TendonCommand::Follow; self.tendons];
        let mut largest_m = 0.0_f64;
        for (index, segment) in self.segments.iter().enumerate() {
            let segment_bend_m = [bend_m[2 * index], bend_m[2 * index + 1]];
            for &(tendon, angle_deg) in segment.actuated(segment_bend_m).into_iter().flatten() {
                // A tendon of a later segment passes the earlier ones and bends with them.
                let pull_m = if index == 0 {
                    projected(segment_bend_m, angle_deg)
                } else {
                    self.pull_m(bend_m, index, angle_deg)
                };
                largest_m = largest_m.max(pull_m.abs());
                // No minus zero: it would be told as such.
                commands[tendon] = TendonCommand::Pull(pull_m + 0.0);
            }
        }
        let max_bend_m = bend_m.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        if largest_m > max_bend_m {
            // All commands shrink together, so that the direction of the bend stays.
            let share = max_bend_m / largest_m;
            for command in &mut commands {
                if let TendonCommand::Pull(pull_m) = command {
                    *pull_m = (*pull_m * share).clamp(-max_bend_m, max_bend_m);
                }
            }
        }
        commands
    }

    /// Displacement of a tendon of segment `index` at `angle_deg` from the segment's first: it
    /// passes the segments before, and their bends take it along.
    fn pull_m(&self, bend_m: &[f64], index: usize, angle_deg: f64) -> f64 {
        let along = self.segments[index].first_deg + angle_deg;
        let part = |(number, segment): (usize, &SegmentBend)| {
            projected([bend_m[2 * number], bend_m[2 * number + 1]], along - segment.first_deg)
        };
        self.segments[..=index].iter().enumerate().map(part).sum()
    }
}

impl SegmentBend {
    /// The tendons on both sides of a bend; one where the segment bends in a plane only, and none
    /// after it.
    fn actuated(&self, [a, b]: [f64; 2]) -> [Option<&(usize, f64)>; 2] {
        let tendons = &self.tendons;
        if let [first, opposite] = tendons.as_slice() {
            // Two tendons bend in one plane; the second component has no effect.
            return [Some(if a >= 0.0 { first } else { opposite }), None];
        }
        if self.is_cross() {
            // Every axis has a pair of its own; at zero the first of the pair is pulled.
            return [
                Some(&tendons[if a >= 0.0 { 0 } else { 2 }]),
                Some(&tendons[if b >= 0.0 { 1 } else { 3 }]),
            ];
        }
        let towards_deg = b.atan2(a).to_degrees().rem_euclid(360.0);
        let last_before =
            tendons.iter().rposition(|&(_, angle_deg)| angle_deg <= towards_deg).unwrap_or(0);
        let mut first_after = (last_before + 1) % tendons.len();
        // Two tendons at one angle: the next that lies further on.
        while tendons[first_after].1 == tendons[last_before].1 && first_after != last_before {
            first_after = (first_after + 1) % tendons.len();
        }
        [Some(&tendons[last_before]), Some(&tendons[first_after])]
    }

    /// Four tendons a quarter of a turn apart.
    fn is_cross(&self) -> bool {
        let quarter = |(index, &(_, angle_deg)): (usize, &(usize, f64))| {
            (angle_deg - 90.0 * index as f64).abs() < 1e-9
        };
        self.tendons.len() == 4 && self.tendons.iter().enumerate().all(quarter)
    }
}

/// The part of a bend along a direction, exact at quarters of a turn.
fn projected([a, b]: [f64; 2], angle_deg: f64) -> f64 {
    match angle_deg.rem_euclid(360.0) {
        0.0 => a,
        90.0 => b,
        180.0 => -a,
        270.0 => -b,
        other => a * other.to_radians().cos() + b * other.to_radians().sin(),
    }
}

/// Drives from one bend to another, in steps of at most `max_step_m` per component. Returns the
/// last observation, or `None` when the two bends are the same.
pub(crate) fn drive_to(
    plant: &mut dyn Plant,
    map: &BendMap,
    from_m: &mut Bend,
    to_m: Bend,
    max_step_m: f64,
) -> Result<Option<Observation>, PlantError> {
    let count = steps_between(from_m, &to_m, max_step_m);
    let start_m = from_m.clone();
    let mut observation = None;
    for step in 1..=count {
        let share = step as f64 / count as f64;
        for (axis, value_m) in from_m.iter_mut().enumerate() {
            *value_m = start_m[axis] + share * (to_m[axis] - start_m[axis]);
        }
        observation = Some(plant.drive(&map.commands(from_m))?);
    }
    // Exactly the target: shares of a step leave rounding behind.
    *from_m = to_m;
    Ok(observation)
}

/// Number of equal steps of at most `max_step_m` per component from one set of displacements to
/// another.
pub(crate) fn steps_between(from_m: &[f64], to_m: &[f64], max_step_m: f64) -> usize {
    let largest_m = from_m.iter().zip(to_m).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max);
    // The tolerance keeps a step of exactly the limit a single step.
    (largest_m / max_step_m - 1e-9).ceil().max(0.0) as usize
}

/// A serpentine over a square of the actuation plane: `rows` values of a, for each of them
/// `columns` values of b.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GridOptions {
    /// Values of a (pull towards tendon 1 or 3).
    pub rows: usize,
    /// Values of b (pull towards tendon 2 or 4), in alternating direction.
    pub columns: usize,
    /// Half the side of the square.
    pub max_pull_m: f64,
    /// Largest change of either pull in a step; wider gaps are crossed in several steps.
    pub max_step_m: f64,
}

impl Default for GridOptions {
    fn default() -> Self {
        GridOptions { rows: 25, columns: 40, max_pull_m: 0.03, max_step_m: 0.003 }
    }
}

impl GridOptions {
    /// Checks every range.
    ///
    /// # Errors
    /// [`BadOption`] names the first field out of range.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("max_pull_m", self.max_pull_m)?;
        BadOption::unless_positive("max_step_m", self.max_step_m)?;
        for (key, count) in [("rows", self.rows), ("columns", self.columns)] {
            if count < 2 {
                return Err(BadOption {
                    key,
                    found: count.to_string(),
                    expected: "a whole number of at least 2",
                });
            }
        }
        Ok(())
    }

    /// The bends in the order of the visits, metres. Every further segment visits the square in
    /// another order: column by column, and from another corner.
    pub(crate) fn bends_m(&self, map: &BendMap) -> Vec<Bend> {
        let count = self.rows * self.columns;
        let segments = map.segments.len();
        let bend = |visit: usize| {
            let part = |segment: usize| {
                // Segments that bent alike would show only a part of the workspace.
                let shifted = (visit + segment * count / segments) % count;
                self.node_m(shifted, segment % 2 == 1)
            };
            (0..segments).flat_map(part).collect()
        };
        (0..count).map(bend).collect()
    }

    /// The node of a serpentine along the rows, or along the columns. Every other line is visited
    /// backwards, so that consecutive nodes are neighbours.
    fn node_m(&self, visit: usize, along_columns: bool) -> [f64; 2] {
        let at = |index: usize, count: usize| {
            (2.0 * index as f64 / (count - 1) as f64 - 1.0) * self.max_pull_m
        };
        let (per_line, lines) =
            if along_columns { (self.rows, self.columns) } else { (self.columns, self.rows) };
        let (line, place) = (visit / per_line, visit % per_line);
        let place = if line % 2 == 0 { place } else { per_line - 1 - place };
        if along_columns {
            [at(place, per_line), at(line, lines)]
        } else {
            [at(line, lines), at(place, per_line)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::PlacedTendon;
    use std::f64::consts::TAU;

    fn pulls(map: &BendMap, bend_m: &[f64]) -> Vec<Option<f64>> {
        let pull = |command: TendonCommand| match command {
            TendonCommand::Pull(pull_m) => Some(pull_m),
            TendonCommand::Follow => None,
        };
        map.commands(bend_m).into_iter().map(pull).collect()
    }

    #[test]
    fn four_tendons_are_two_opposite_pairs() {
        let map = BendMap::new(&TendonLayout::ring(4));
        assert_eq!(pulls(&map, &[0.01, 0.02]), [Some(0.01), Some(0.02), None, None]);
        assert_eq!(pulls(&map, &[-0.01, 0.02]), [None, Some(0.02), Some(0.01), None]);
        assert_eq!(pulls(&map, &[-0.01, -0.02]), [None, None, Some(0.01), Some(0.02)]);
        assert_eq!(pulls(&map, &[0.0, 0.0]), [Some(0.0), Some(0.0), None, None]);
    }

    #[test]
    fn the_two_tendons_beside_a_bend_of_any_ring_take_its_projection_and_the_limit_holds() {
        for count in [3, 5, 6, 9] {
            let map = BendMap::new(&TendonLayout::ring(count));
            for turn in 0..360 {
                let angle = TAU * f64::from(turn) / 360.0 + 0.001;
                let bend_m = [0.02 * angle.cos(), 0.02 * angle.sin()];
                let all = pulls(&map, &bend_m);
                assert_eq!(all.iter().flatten().count(), 2, "{count} tendons at {turn}°");
                let share = all.iter().enumerate().find_map(|(tendon, pull)| {
                    let whole = 0.02 * (angle - TAU * tendon as f64 / count as f64).cos();
                    pull.filter(|_| whole.abs() > 1e-3).map(|pull_m| pull_m / whole)
                });
                let share = share.unwrap();
                assert!(share > 0.7 && share < 1.0 + 1e-12, "{count} tendons at {turn}°: {share}");
                let largest = bend_m[0].abs().max(bend_m[1].abs());
                assert!(all.iter().flatten().all(|pull_m| pull_m.abs() <= largest + 1e-15));
            }
        }
    }

    #[test]
    fn tendons_of_a_further_segment_go_along_with_the_bends_before() {
        let place = |tendon: usize| PlacedTendon { tendon, angle_deg: 120.0 * (tendon % 3) as f64 };
        let layout = TendonLayout {
            segments: vec![(0..3).map(place).collect(), (3..6).map(place).collect()],
        };
        let map = BendMap::new(&layout);
        // The base segment bends towards its first tendon, the further one is straight relative to
        // it.
        let all = pulls(&map, &[0.02, 0.0, 0.0, 0.0]);
        assert_eq!((all[0], all[3]), (Some(0.02), Some(0.02)));
        assert!((all[1].unwrap() + 0.01).abs() < 1e-12, "{all:?}");
        // Both bend: the sum is scaled to the limit.
        assert_eq!(pulls(&map, &[0.02, 0.0, 0.02, 0.0])[3], Some(0.02));
    }

    #[test]
    fn two_opposite_tendons_bend_in_a_plane() {
        let map = BendMap::new(&TendonLayout::ring(2));
        assert_eq!(pulls(&map, &[0.01, 0.03]), [Some(0.01), None]);
        assert_eq!(pulls(&map, &[-0.01, 0.0]), [None, Some(0.01)]);
    }

    #[test]
    fn a_grid_visits_every_node_of_every_segment_once() {
        let grid = GridOptions { rows: 3, columns: 5, max_pull_m: 0.03, max_step_m: 0.003 };
        let place = |tendon: usize| PlacedTendon { tendon, angle_deg: 120.0 * (tendon % 3) as f64 };
        let layout = TendonLayout {
            segments: vec![(0..3).map(place).collect(), (3..6).map(place).collect()],
        };
        let bends = grid.bends_m(&BendMap::new(&layout));
        for segment in 0..2 {
            let mut nodes: Vec<String> =
                bends.iter().map(|bend| format!("{:?}", &bend[2 * segment..][..2])).collect();
            nodes.sort();
            nodes.dedup();
            assert_eq!(nodes.len(), 15, "segment {segment}");
        }
    }
}
