//! An inverse network that learns in simulation to control robots which differ: the model with
//! effects of the catalogue that nobody has measured (domain randomisation, Tobin et al. 2017),
//! along the ways that it takes itself, each of whose ticks is labelled with the command that has
//! this robot's tip at the target (DAgger, Ross, Gordon & Bagnell 2011). It needs no real point;
//! what a robot is like it has to gather from the tips that it is shown.

use crate::policies::parts::inverse_network::InverseNetworkController;
use crate::policies::parts::single_controller::SingleController;
use crate::policies::{
    BadOption, DAGGER, Deserialize, ModelNeed, PolicyEntry, Serialize, SeriesLabel,
};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "dagger",
    label: SeriesLabel::text("DAgger"),
    footnote: "trained in simulation on robots that differ, without real data.",
    needs: &[ModelNeed::Network(&DAGGER)],
    make: |mut parts, options| {
        let model = parts.inverse("dagger", &DAGGER)?;
        Ok(Box::new(SingleController::new(
            InverseNetworkController::new(model, options),
            "",
            options,
        )))
    },
    ..PolicyEntry::PLAIN
};

/// Training data of the network. New robots are drawn in every round.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DaggerOptions {
    /// Rounds of recording and training, 1 to 20. In the first one the inverse network of the model
    /// controls.
    pub rounds: usize,
    /// Robots of a round, 1 to 1000.
    pub robots: usize,
    /// Targets of a robot, 1 to 1000.
    pub targets: usize,
    /// Ticks at a target, from rest at home, 1 to 1000.
    pub ticks: usize,
    /// Largest number of effects of the catalogue in a robot; at least one.
    pub most_effects: usize,
    /// Standard deviation of an effect's signed strength, in usual sizes, above 0 and up to 5.
    pub strength: f64,
    /// Standard deviation of the tracking noise on each axis, metres.
    pub noise_m: f64,
}

impl Default for DaggerOptions {
    fn default() -> Self {
        DaggerOptions {
            rounds: 3,
            robots: 40,
            targets: 8,
            ticks: 20,
            most_effects: 5,
            strength: 1.0,
            noise_m: 0.0005,
        }
    }
}

impl DaggerOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_within("rounds", self.rounds, 1..=20, "a whole number from 1 to 20")?;
        BadOption::unless_within("robots", self.robots, 1..=1000, "a whole number from 1 to 1000")?;
        BadOption::unless_within(
            "targets",
            self.targets,
            1..=1000,
            "a whole number from 1 to 1000",
        )?;
        BadOption::unless_within("ticks", self.ticks, 1..=1000, "a whole number from 1 to 1000")?;
        BadOption::unless_within(
            "most_effects",
            self.most_effects,
            1..=10,
            "a whole number from 1 to 10",
        )?;
        let within = self.strength > 0.0 && self.strength <= 5.0;
        BadOption::unless(within, "strength", self.strength, "a number above 0 and up to 5")?;
        BadOption::unless_not_negative("noise_m", self.noise_m)
    }

    /// Samples of all rounds, where no robot fails.
    pub fn samples(&self) -> usize {
        self.rounds * self.robots * self.targets * self.ticks
    }
}
