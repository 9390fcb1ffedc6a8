//! Transport delay of the commands.

use std::collections::VecDeque;

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, Seek, Serialize};

/// A transport delay between command and drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Delay {
    /// Delay, s.
    pub time_s: f64,
    /// Pending commands with their age, oldest first.
    #[serde(skip)]
    past: VecDeque<(f64, Vec<f64>)>,
}

/// Two ticks at 5 Hz in steps of the drive time: whether a command acts before or after the tracker
/// samples is resolved within one step.
const SCANNED_DELAYS_S: [f64; 20] = [
    0.02, 0.04, 0.06, 0.08, 0.10, 0.12, 0.14, 0.16, 0.18, 0.20, 0.22, 0.24, 0.26, 0.28, 0.30, 0.32,
    0.34, 0.36, 0.38, 0.40,
];

pub(crate) const CARD: Card = Card {
    name: "delay",
    missing: "delay of the commands",
    equation: "q(t) → q(t − time)",
    source: "transport delay",
    parameters: &[Parameter {
        name: "time_s",
        unit: "s",
        null: 0.0,
        seek: Seek::Scanned(0.05, &SCANNED_DELAYS_S),
    }],
    usual_change: None,
    confused_with: &["damping", "backlash"],
};

impl Effect for Delay {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("time_s", self.time_s)
    }

    fn reset(&mut self) {
        self.past.clear();
    }

    fn has_lag(&self) -> bool {
        self.time_s > 0.0
    }

    /// The command one delay ago, linearly interpolated between instants.
    fn modify_command(&mut self, pulls_m: &mut [f64], dt_s: f64) {
        if self.time_s <= 0.0 {
            return;
        }
        if dt_s.is_infinite() {
            self.past = VecDeque::from([(0.0, pulls_m.to_vec())]);
            return;
        }
        if self.past.is_empty() {
            self.past.push_back((0.0, vec![0.0; pulls_m.len()]));
        }
        self.past.iter_mut().for_each(|(age, _)| *age += dt_s);
        self.past.push_back((0.0, pulls_m.to_vec()));
        // The first two are those around the delayed time.
        while self.past.len() > 2 && self.past[1].0 >= self.time_s {
            self.past.pop_front();
        }
        let ((old_age, old), (new_age, new)) = (&self.past[0], &self.past[1]);
        let share = ((old_age - self.time_s) / (old_age - new_age)).clamp(0.0, 1.0);
        for (pull, (from, to)) in pulls_m.iter_mut().zip(old.iter().zip(new)) {
            *pull = from + share * (to - from);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn played(time_s: f64) -> Vec<f64> {
        let mut delay = Delay { time_s, past: VecDeque::new() };
        let play = |command: &f64| {
            let mut pulls = [*command];
            delay.modify_command(&mut pulls, 0.2);
            pulls[0]
        };
        [1.0, 2.0, 3.0, 4.0].iter().map(play).collect()
    }

    #[test]
    fn whole_and_partial_steps_of_delay() {
        assert_eq!(played(0.0), [1.0, 2.0, 3.0, 4.0]);
        let close = |a: Vec<f64>, b: [f64; 4]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-12);
        assert!(close(played(0.2), [0.0, 1.0, 2.0, 3.0]), "{:?}", played(0.2));
        assert!(close(played(0.1), [0.5, 1.5, 2.5, 3.5]), "{:?}", played(0.1));
        assert!(close(played(0.3), [0.0, 0.5, 1.5, 2.5]), "{:?}", played(0.3));
    }
}
