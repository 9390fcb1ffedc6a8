//! A robot that changes at a time that nobody announces.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::base::{BadOption, Observation, Plant, PlantError, Seed, TendonCommand, TendonLayout};
use crate::effects::EffectSpec;

/// A change of a robot during a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotChange {
    /// The time of the change, drawn anew in each trial between these two, seconds.
    pub between_s: [f64; 2],
    /// The effects that the robot has from then on, beside its own.
    pub effects: Vec<EffectSpec>,
}

impl RobotChange {
    /// Checks the times.
    ///
    /// # Errors
    /// [`BadOption`] for times that are no interval.
    pub fn check(&self) -> Result<(), BadOption> {
        let [from_s, to_s] = self.between_s;
        let holds = from_s >= 0.0 && from_s <= to_s && to_s.is_finite();
        let expected = "two times, the earlier first";
        BadOption::unless(holds, "between_s", format!("[{from_s}, {to_s}]"), expected)
    }
}

/// Steps in which the changed robot comes to the command in force and to rest.
const SETTLING_STEPS: u32 = 20;

/// A robot before and after its change, as one plant. The changed robot goes on from its rest under
/// the command in force, so what the other one remembered (friction, creep) is lost.
pub struct Changing {
    before: Box<dyn Plant>,
    after: Box<dyn Plant>,
    between_s: [f64; 2],
    change_s: f64,
    time_s: f64,
    has_changed: bool,
    seed: Seed,
    in_force: Vec<TendonCommand>,
}

impl Changing {
    /// A robot that becomes another one with the same tendons between two times of each trial,
    /// seconds.
    pub fn new(before: Box<dyn Plant>, after: Box<dyn Plant>, between_s: [f64; 2]) -> Changing {
        let in_force = vec![TendonCommand::Pull(0.0); before.tendons()];
        let (change_s, time_s, has_changed, seed) = (f64::INFINITY, 0.0, false, Seed(0));
        Changing { before, after, between_s, change_s, time_s, has_changed, seed, in_force }
    }

    fn change(&mut self) -> Result<(), PlantError> {
        self.has_changed = true;
        self.after.reset(self.seed.child("changed"))?;
        for step in 1..=SETTLING_STEPS {
            let share = (f64::from(2 * step) / f64::from(SETTLING_STEPS)).min(1.0);
            let towards = |command: &TendonCommand| match *command {
                TendonCommand::Pull(pull_m) => TendonCommand::Pull(share * pull_m),
                TendonCommand::Follow => TendonCommand::Follow,
            };
            let commands: Vec<TendonCommand> = self.in_force.iter().map(towards).collect();
            self.after.drive(&commands)?;
        }
        Ok(())
    }
}

impl Plant for Changing {
    fn tendons(&self) -> usize {
        self.before.tendons()
    }

    fn points(&self) -> Vec<String> {
        self.before.points()
    }

    fn tendon_layout(&self) -> TendonLayout {
        self.before.tendon_layout()
    }

    fn step_s(&self) -> f64 {
        self.before.step_s()
    }

    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError> {
        let [from_s, to_s] = self.between_s;
        let share: f64 = seed.child("change").rng().random();
        (self.change_s, self.time_s, self.has_changed, self.seed) =
            (from_s + share * (to_s - from_s), 0.0, false, seed);
        self.in_force.fill(TendonCommand::Pull(0.0));
        self.before.reset(seed)
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        if self.time_s >= self.change_s && !self.has_changed {
            self.change()?;
        }
        let robot = if self.has_changed { &mut self.after } else { &mut self.before };
        let mut observation = robot.drive(commands)?;
        self.time_s += self.before.step_s();
        observation.time_s = self.time_s;
        self.in_force = commands.to_vec();
        Ok(observation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plants::{ConstantCurvature, ConstantCurvatureOptions};

    fn robot(shift_m: f64) -> Box<dyn Plant> {
        let options = ConstantCurvatureOptions {
            shift_m: [shift_m, 0.0, 0.0],
            ..ConstantCurvatureOptions::default()
        };
        Box::new(ConstantCurvature::new(options).unwrap())
    }

    #[test]
    fn the_robot_changes_once_in_a_trial_at_a_time_that_its_seed_draws() {
        let mut changing = Changing::new(robot(0.0), robot(0.05), [1.0, 3.0]);
        let pulls_m = [0.004, 0.0, -0.004, 0.0];
        let mut steps_before = |seed| {
            changing.reset(Seed(seed)).unwrap();
            let tips: Vec<f64> =
                (0..20).map(|_| changing.step(&pulls_m).unwrap().tip_m[0]).collect();
            // At rest before the change and after it, without the way from home in between.
            assert!((tips[19] - tips[4] - 0.05).abs() < 1e-3, "{tips:?}");
            tips.iter().filter(|&&tip_m| tip_m < 0.05).count()
        };
        let times = [steps_before(1), steps_before(2), steps_before(3), steps_before(1)];
        assert_eq!(times[0], times[3]);
        assert!(times.iter().all(|steps| (5..=16).contains(steps)), "{times:?}");
        assert!(times[0] != times[1] || times[1] != times[2], "{times:?}");
    }
}
