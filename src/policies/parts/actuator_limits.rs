//! What the drive can do: its travel and how far it moves in a tick.

use serde::{Deserialize, Serialize};

use crate::base::{BadOption, Displacements, PolicyError};

/// Limits of the drive, the same for every policy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LimitOptions {
    /// Largest displacement of a tendon in either direction.
    pub travel_m: f64,
    /// Largest change of a displacement in one tick; `null` for none. The change of all tendons is
    /// scaled together, so that the robot moves straight towards the demanded displacements.
    pub max_step_m: Option<f64>,
}

impl Default for LimitOptions {
    fn default() -> Self {
        LimitOptions { travel_m: 0.03, max_step_m: Some(0.003) }
    }
}

impl LimitOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("travel_m", self.travel_m)?;
        BadOption::unless_positive_or_null("max_step_m", self.max_step_m)
    }
}

/// Changes below this are rounding, not a limit that binds.
const ROUNDING_M: f64 = 1e-12;

/// The limits and the command in force.
pub(crate) struct ActuatorLimits {
    options: LimitOptions,
    last_m: Option<Displacements>,
}

/// A command that the drive can carry out.
pub(crate) struct LimitedCommand {
    pub(crate) pulls_m: Displacements,
    /// False while the step limit keeps the command from what is demanded.
    pub(crate) arrived: bool,
}

impl ActuatorLimits {
    pub(crate) fn new(options: LimitOptions) -> Self {
        ActuatorLimits { options, last_m: None }
    }

    pub(crate) fn reset(&mut self) {
        self.last_m = None;
    }

    /// What of `demand_m` can be had in this tick, and makes it the command in force. Until there
    /// is one, `in_force_m` are the displacements observed at the trial's start.
    pub(crate) fn apply(
        &mut self,
        demand_m: &[f64],
        in_force_m: &[f64],
    ) -> Result<LimitedCommand, PolicyError> {
        let limited = self.limit(demand_m, in_force_m)?;
        self.last_m = Some(limited.pulls_m.clone());
        Ok(limited)
    }

    /// [`ActuatorLimits::apply`] without making it so.
    pub(crate) fn limit(
        &self,
        demand_m: &[f64],
        in_force_m: &[f64],
    ) -> Result<LimitedCommand, PolicyError> {
        if demand_m.len() != in_force_m.len() {
            return Err(PolicyError::Tendons { found: demand_m.len(), expected: in_force_m.len() });
        }
        PolicyError::unless_finite("tendon displacement", demand_m.iter().chain(in_force_m))?;
        let travel_m = self.options.travel_m;
        let goal: Displacements =
            demand_m.iter().map(|pull| pull.clamp(-travel_m, travel_m)).collect();
        let last = self.last_m.as_deref().unwrap_or(in_force_m);
        let largest = largest_change_m(last, &goal);
        let share = self.options.max_step_m.map_or(1.0, |step_m| (step_m / largest).min(1.0));
        let pulls_m: Displacements = if share >= 1.0 {
            goal
        } else {
            last.iter()
                .zip(&goal)
                .map(|(from, to)| (from + share * (to - from)).clamp(-travel_m, travel_m))
                .collect()
        };
        Ok(LimitedCommand { pulls_m, arrived: (1.0 - share) * largest <= ROUNDING_M })
    }
}

/// Largest difference of two commands over the tendons, metres.
pub(crate) fn largest_change_m(from_m: &[f64], to_m: &[f64]) -> f64 {
    from_m.iter().zip(to_m).map(|(from, to)| (from - to).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_far_command_is_reached_in_steps_along_a_straight_line() {
        let mut limits =
            ActuatorLimits::new(LimitOptions { travel_m: 0.03, max_step_m: Some(0.003) });
        let home = [0.0; 4];
        let demand = [0.009, 0.003, -0.009, -0.003];
        let first = limits.apply(&demand, &home).unwrap();
        for (found, expected) in first.pulls_m.iter().zip([0.003, 0.001, -0.003, -0.001]) {
            assert!((found - expected).abs() < 1e-15);
        }
        assert!(!first.arrived);
        limits.apply(&demand, &home).unwrap();
        let third = limits.apply(&demand, &home).unwrap();
        assert!(third.arrived);
        assert!(largest_change_m(&third.pulls_m, &demand) < 1e-15);
    }

    #[test]
    fn travel_binds_and_still_counts_as_arrived() {
        let mut limits = ActuatorLimits::new(LimitOptions { travel_m: 0.03, max_step_m: None });
        let limited = limits.apply(&[1.0, 0.0], &[0.0, 0.0]).unwrap();
        assert_eq!(limited.pulls_m, vec![0.03, 0.0]);
        assert!(limited.arrived);
    }
}
