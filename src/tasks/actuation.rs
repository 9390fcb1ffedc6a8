//! Four tendons as two opposite pairs: a point (a, b) of the actuation plane, in metres, is the pull towards tendon 1
//! (a > 0) or 3 and towards tendon 2 (b > 0) or 4. Two neighbouring tendons are actuated, "the remaining two tendon
//! lengths" follow the shape (section IV-A).

use serde::{Deserialize, Serialize};

use crate::base::{BadOption, Observation, Plant, PlantError, TendonCommand};

/// A point of the actuation plane, metres.
pub(super) type Bend = [f64; 2];

/// The commands for a point of the actuation plane, metres: the tendon on the side of the sign is pulled, its opposite
/// follows; at zero the first of the pair is pulled.
pub fn bend_commands(bend_m: [f64; 2]) -> [TendonCommand; 4] {
    let mut commands = [TendonCommand::Follow; 4];
    for (axis, value_m) in bend_m.into_iter().enumerate() {
        let tendon = if value_m >= 0.0 { axis } else { axis + 2 };
        commands[tendon] = TendonCommand::Pull(value_m.abs());
    }
    commands
}

/// Refuses a plant without two opposite pairs of tendons.
pub(super) fn check_pairs(plant: &dyn Plant) -> Result<(), PlantError> {
    if plant.tendons() == 4 {
        return Ok(());
    }
    Err(PlantError::Refused(format!("{} tendons, expected two opposite pairs (4)", plant.tendons())))
}

/// Drives from one point of the actuation plane to another, in steps of at most `max_step_m` per axis. Returns the last
/// observation, or `None` when the two points are the same.
pub(super) fn drive_to(
    plant: &mut dyn Plant,
    from_m: &mut Bend,
    to_m: Bend,
    max_step_m: f64,
) -> Result<Option<Observation>, PlantError> {
    let largest_m = (to_m[0] - from_m[0]).abs().max((to_m[1] - from_m[1]).abs());
    // The tolerance keeps a step of exactly the limit a single step.
    let count = (largest_m / max_step_m - 1e-9).ceil().max(0.0);
    let start_m = *from_m;
    let mut last = None;
    for step in 1..=(count as usize) {
        let share = step as f64 / count;
        *from_m = std::array::from_fn(|axis| start_m[axis] + share * (to_m[axis] - start_m[axis]));
        last = Some(plant.drive(&bend_commands(*from_m))?);
    }
    *from_m = to_m;
    Ok(last)
}

/// A serpentine over a square of the actuation plane: `rows` values of a, for each of them `columns` values of b.
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
                return Err(BadOption { key, found: count.to_string(), expected: "a whole number of at least 2" });
            }
        }
        Ok(())
    }

    /// The points in the order of the visits, metres.
    pub(super) fn points_m(&self) -> Vec<Bend> {
        let at = |index: usize, count: usize| (2.0 * index as f64 / (count - 1) as f64 - 1.0) * self.max_pull_m;
        let mut points = Vec::with_capacity(self.rows * self.columns);
        for row in 0..self.rows {
            for column in 0..self.columns {
                let column = if row % 2 == 0 { column } else { self.columns - 1 - column };
                points.push([at(row, self.rows), at(column, self.columns)]);
            }
        }
        points
    }
}
