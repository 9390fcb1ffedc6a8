//! The command acts late.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::{Card, Effect, Parameter};
use crate::base::BadOption;

/// A transport delay between command and drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Delay {
    /// Delay, s.
    pub time_s: f64,
    /// Commands under way with their age, oldest first.
    #[serde(skip)]
    pending: VecDeque<(f64, Vec<f64>)>,
}

pub(super) const CARD: Card = Card {
    name: "delay",
    missing: "command acts late",
    equation: "q(t) → q(t − time)",
    source: "transport delay",
    parameters: &[Parameter { name: "time_s", unit: "s", null: 0.0 }],
    confused_with: &["damping", "backlash"],
};

impl Effect for Delay {
    fn check(&self) -> Result<(), BadOption> {
        super::non_negative("time_s", self.time_s)
    }

    fn reset(&mut self) {
        self.pending.clear();
    }

    /// The drive moves to the mean over this step of what the delayed command asks for: delays that are not whole
    /// steps act in proportion.
    fn command(&mut self, pulls_m: &mut [f64], dt_s: f64) {
        if self.time_s <= 0.0 {
            return;
        }
        if dt_s.is_infinite() {
            self.pending = VecDeque::from([(f64::INFINITY, pulls_m.to_vec())]);
            return;
        }
        if self.pending.is_empty() {
            self.pending.push_back((f64::INFINITY, vec![0.0; pulls_m.len()]));
        }
        self.pending.push_back((0.0, pulls_m.to_vec()));
        // Ages are times since the command was given, at the end of this step.
        self.pending.iter_mut().for_each(|(age, _)| *age += dt_s);
        pulls_m.fill(0.0);
        let mut covered = 0.0;
        for (age, command) in self.pending.iter().rev() {
            let reached = ((age - self.time_s) / dt_s).clamp(0.0, 1.0);
            for (pull, told) in pulls_m.iter_mut().zip(command) {
                *pull += (reached - covered) * told;
            }
            covered = reached;
        }
        while self.pending.len() > 1 && self.pending[1].0 >= self.time_s + dt_s {
            self.pending.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn played(time_s: f64) -> Vec<f64> {
        let mut delay = Delay { time_s, pending: VecDeque::new() };
        let play = |command: &f64| {
            let mut pulls = [*command];
            delay.command(&mut pulls, 0.2);
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
