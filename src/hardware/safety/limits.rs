//! Limits of commands.

use serde::{Deserialize, Serialize};

use crate::base::BadOption;

/// Limits of the drive and of the tracking.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SafetyLimits {
    /// Largest displacement of a tendon in either direction, metres.
    pub travel_m: f64,
    /// Largest change of a displacement from one command to the next, metres.
    pub max_step_m: f64,
    /// Largest speed of a tendon, m/s.
    pub max_speed_m_s: f64,
    /// Largest length by which two opposite tendons together may be released, metres; a slacker
    /// tendon falls off its spool.
    pub slack_m: f64,
    /// Largest length by which two opposite tendons together may be pulled in, metres; more would
    /// crush the spine.
    pub over_tension_m: f64,
    /// Age of the last valid pose above which the robot is held, s.
    pub tracking_hold_s: f64,
    /// Duration of a hold after which the robot is stopped, s.
    pub hold_stop_s: f64,
    /// Holds within ten seconds above which the robot is stopped.
    pub most_holds: usize,
    /// Largest plausible distance of the measured tip from the predicted one, metres.
    pub tip_from_model_m: f64,
    /// Largest plausible speed of the tip, m/s.
    pub tip_speed_m_s: f64,
    /// Largest motion of the tip at rest at home over a trial, metres; twice as much since it rested
    /// there first.
    pub home_tolerance_m: f64,
    /// Delay of a command or of a measurement above which the trial ends, in ticks; holds apart.
    pub max_late_ticks: f64,
}

impl Default for SafetyLimits {
    /// Reasons: docs/reference/hardware.md, "Design choices".
    fn default() -> Self {
        SafetyLimits {
            travel_m: 0.03,
            max_step_m: 0.003,
            max_speed_m_s: 0.02,
            slack_m: 0.02,
            over_tension_m: 0.03,
            tracking_hold_s: 0.05,
            hold_stop_s: 0.2,
            most_holds: 5,
            tip_from_model_m: 0.08,
            tip_speed_m_s: 5.0,
            home_tolerance_m: 0.0025,
            max_late_ticks: 0.3,
        }
    }
}

/// Most ticks of one command; a longer one is a mistake.
pub const MAX_TICKS: usize = 4;

/// Rounding tolerance of all limits, metres.
const ROUNDING_M: f64 = 1e-9;

/// Why a command is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CommandRefusal {
    /// A displacement is not finite.
    #[error("tendon {tendon}: found {found}, expected a finite displacement")]
    NotFinite {
        /// From 1.
        tendon: usize,
        /// Requested displacement.
        found: f64,
    },
    /// The number of displacements differs from the number of tendons.
    #[error("found {found} displacements, expected {expected}")]
    Count {
        /// Number given.
        found: usize,
        /// Number of tendons.
        expected: usize,
    },
    /// A limit is exceeded.
    #[error("tendon {tendon}: {what} of {found:.6}, expected {low:.6} to {high:.6}")]
    Beyond {
        /// From 1.
        tendon: usize,
        /// The limited quantity, with its unit.
        what: &'static str,
        /// Requested value.
        found: f64,
        /// Smallest permitted value.
        low: f64,
        /// Largest permitted value.
        high: f64,
    },
}

impl SafetyLimits {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("travel_m", self.travel_m)?;
        BadOption::unless_positive("max_step_m", self.max_step_m)?;
        BadOption::unless_positive("max_speed_m_s", self.max_speed_m_s)?;
        BadOption::unless_positive("slack_m", self.slack_m)?;
        BadOption::unless_positive("over_tension_m", self.over_tension_m)?;
        BadOption::unless_positive("tracking_hold_s", self.tracking_hold_s)?;
        BadOption::unless_positive("hold_stop_s", self.hold_stop_s)?;
        BadOption::unless_counted("most_holds", self.most_holds)?;
        BadOption::unless_positive("tip_from_model_m", self.tip_from_model_m)?;
        BadOption::unless_positive("tip_speed_m_s", self.tip_speed_m_s)?;
        BadOption::unless_positive("home_tolerance_m", self.home_tolerance_m)?;
        BadOption::unless_positive("max_late_ticks", self.max_late_ticks)
    }

    /// Largest change of a displacement in `duration_s`, metres.
    pub fn step_m(&self, duration_s: f64) -> f64 {
        self.max_step_m.min(self.max_speed_m_s * duration_s)
    }

    /// Number of ticks of `tick_s` from `last_m` to `pulls_m`; 0 if nothing moves or a value is not
    /// a number.
    pub fn ticks(&self, pulls_m: &[f64], last_m: &[f64], tick_s: f64) -> usize {
        let changes = pulls_m.iter().zip(last_m).map(|(to, from)| (to - from).abs());
        let largest_m =
            changes.fold(0.0, |largest, change| if change > largest { change } else { largest });
        ((largest_m - ROUNDING_M) / self.step_m(tick_s)).ceil().max(0.0) as usize
    }

    /// Checks the command `pulls_m` after `last_m`, executed in `duration_s` and `steps` steps.
    /// Opposite tendons are half the number of tendons apart.
    ///
    /// # Errors
    /// [`CommandRefusal`] names the first limit that is exceeded.
    pub fn check_command(
        &self,
        pulls_m: &[f64],
        last_m: &[f64],
        duration_s: f64,
        steps: usize,
    ) -> Result<(), CommandRefusal> {
        self.check_each_tendon(pulls_m, last_m, duration_s, steps)?;
        self.check_antagonists(pulls_m, last_m)
    }

    /// The checks of [`SafetyLimits::check_command`] that concern one tendon at a time.
    ///
    /// # Errors
    /// [`CommandRefusal`] names the first limit that is exceeded.
    pub fn check_each_tendon(
        &self,
        pulls_m: &[f64],
        last_m: &[f64],
        duration_s: f64,
        steps: usize,
    ) -> Result<(), CommandRefusal> {
        if pulls_m.len() != last_m.len() {
            return Err(CommandRefusal::Count { found: pulls_m.len(), expected: last_m.len() });
        }
        if let Some(index) = pulls_m.iter().position(|pull| !pull.is_finite()) {
            return Err(CommandRefusal::NotFinite { tendon: index + 1, found: pulls_m[index] });
        }
        // The speed limit holds in each step, the step limit as often as there are steps.
        let step_m = self.step_m(duration_s / steps as f64) * steps as f64;
        for (index, (&to, &from)) in pulls_m.iter().zip(last_m).enumerate() {
            within("displacement (m)", index, to, -self.travel_m, self.travel_m)?;
            within("step (m)", index, to - from, -step_m, step_m)?;
        }
        Ok(())
    }

    /// Number of ticks of `tick_s` (at least one) in which the drive may move from `last_m` to
    /// `pulls_m`.
    ///
    /// # Errors
    /// [`CommandRefusal`] names the first limit that is exceeded, over [`MAX_TICKS`] ticks if it
    /// needs more.
    pub fn check_in_ticks(
        &self,
        pulls_m: &[f64],
        last_m: &[f64],
        tick_s: f64,
    ) -> Result<usize, CommandRefusal> {
        let ticks = self.ticks(pulls_m, last_m, tick_s).clamp(1, MAX_TICKS);
        self.check_command(pulls_m, last_m, tick_s * ticks as f64, ticks).map(|()| ticks)
    }

    /// A pair beyond a bound may move back towards it.
    fn check_antagonists(&self, pulls_m: &[f64], last_m: &[f64]) -> Result<(), CommandRefusal> {
        let half = pulls_m.len() / 2;
        if !pulls_m.len().is_multiple_of(2) {
            return Ok(());
        }
        for index in 0..half {
            let (sum, last) =
                (pulls_m[index] + pulls_m[index + half], last_m[index] + last_m[index + half]);
            // The last sum widens the bound: from outside, every step back is permitted.
            let (low, high) = (f64::min(-self.slack_m, last), f64::max(self.over_tension_m, last));
            within("sum with its antagonist (m)", index, sum, low, high)?;
        }
        Ok(())
    }
}

fn within(
    what: &'static str,
    index: usize,
    found: f64,
    low: f64,
    high: f64,
) -> Result<(), CommandRefusal> {
    if found >= low - ROUNDING_M && found <= high + ROUNDING_M {
        return Ok(());
    }
    Err(CommandRefusal::Beyond { tendon: index + 1, what, found, low, high })
}
