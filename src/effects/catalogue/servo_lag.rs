//! Drives that follow their commands with a lag.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, Seek, Serialize};

/// A first-order lag between command and drive, as of a servo with proportional position control.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ServoLag {
    /// Time constant, s.
    pub time_s: f64,
    /// Command and position of each drive at the end of the last motion, metres.
    #[serde(skip)]
    last_m: Vec<(f64, f64)>,
}

pub(crate) const CARD: Card = Card {
    name: "servo_lag",
    missing: "lag of the drives behind their commands",
    equation: "time dq'/dt = q − q'",
    source: "first-order lag of a position servo, Franklin, Powell & Emami-Naeini, Feedback \
             Control of Dynamic Systems",
    parameters: &[Parameter {
        name: "time_s",
        unit: "s",
        null: 0.0,
        seek: Seek::Scanned(0.05, &[0.05, 0.15, 0.4]),
    }],
    usual_change: None,
    confused_with: &["delay", "damping", "creep"],
};

impl Effect for ServoLag {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("time_s", self.time_s)
    }

    fn reset(&mut self) {
        self.last_m.clear();
    }

    fn has_lag(&self) -> bool {
        self.time_s > 0.0
    }

    /// The exact response to a command that moves at constant speed.
    fn modify_command(&mut self, pulls_m: &mut [f64], dt_s: f64) {
        self.last_m.resize(pulls_m.len(), (0.0, 0.0));
        for (pull, last) in pulls_m.iter_mut().zip(&mut self.last_m) {
            let command = *pull;
            if self.time_s > 0.0 && dt_s.is_finite() {
                let steady_lag = self.time_s * (command - last.0) / dt_s;
                *pull = command - steady_lag
                    + (last.1 - last.0 + steady_lag) * (-dt_s / self.time_s).exp();
            }
            *last = (command, *pull);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_followed_one_time_constant_late_and_a_command_that_is_held_is_reached() {
        let mut lag = ServoLag { time_s: 0.1, last_m: Vec::new() };
        let mut play = |command: f64| {
            let mut pulls = [command];
            lag.modify_command(&mut pulls, 0.02);
            pulls[0]
        };
        let ramp: Vec<f64> = (1..=100).map(|k| play(0.001 * f64::from(k))).collect();
        assert!((ramp[99] - (0.1 - 0.1 * 0.001 / 0.02)).abs() < 1e-9, "{}", ramp[99]);
        let held = (0..5).map(|_| play(0.1)).last().unwrap();
        assert!((held - (0.1 - 0.005 * (-1.0_f64).exp())).abs() < 1e-9, "{held}");
    }

    #[test]
    fn steps_of_any_length_add_up_to_the_same() {
        let at_end = |parts: u32| {
            let mut lag = ServoLag { time_s: 0.07, last_m: Vec::new() };
            let mut last = 0.0;
            for k in 1..=parts {
                let mut pulls = [0.01 * f64::from(k) / f64::from(parts)];
                lag.modify_command(&mut pulls, 0.2 / f64::from(parts));
                last = pulls[0];
            }
            last
        };
        assert!((at_end(1) - at_end(8)).abs() < 1e-15);
    }
}
