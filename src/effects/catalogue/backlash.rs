//! Dead zone on reversal.

use crate::effects::{BadOption, Card, Deserialize, Effect, Parameter, Seek, Serialize};

/// Play between each drive and its tendon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Backlash {
    /// Width of the dead zone, metres.
    pub width_m: f64,
    /// Position of the driven end of each tendon, metres.
    #[serde(skip)]
    held_m: Vec<f64>,
}

pub(crate) const CARD: Card = Card {
    name: "backlash",
    missing: "dead zone on reversal",
    equation: "q' = min(max(q', q − width/2), q + width/2)",
    source: "play operator, Brokate & Sprekels, ch. 2",
    parameters: &[Parameter { name: "width_m", unit: "m", null: 0.0, seek: Seek::Size(0.001) }],
    usual_change: Some(0.001),
    confused_with: &["friction", "delay", "hysteresis"],
};

impl Effect for Backlash {
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_not_negative("width_m", self.width_m)
    }

    fn reset(&mut self) {
        self.held_m.clear();
    }

    fn has_memory_at_rest(&self) -> bool {
        true
    }

    fn modify_command(&mut self, pulls_m: &mut [f64], _dt_s: f64) {
        self.held_m.resize(pulls_m.len(), 0.0);
        for (pull, held) in pulls_m.iter_mut().zip(&mut self.held_m) {
            *held = held.clamp(*pull - 0.5 * self.width_m, *pull + 0.5 * self.width_m);
            *pull = *held;
        }
    }
}
