//! Recordings for learning have a tip in every row: a step in which tracking lost the tip is
//! repeated.

use crate::base::{Observation, Plant, PlantError, Seed, TendonCommand, TendonLayout};

/// Steps for which a command is held once more, 2 s at the usual 0.2 s: markers are hidden briefly.
/// A real robot without tracking for longer is stopped by its guard.
const MAX_REPEATS: usize = 10;

/// A plant whose every observation is valid. After a lost frame, the same command is held for
/// another step, and the tip at its end is returned. The number of rows stays the same, so
/// recordings of the same commands on two robots can be compared row by row, which leaving rows out
/// would break.
pub(crate) struct RetryLostFrames<'a>(pub(crate) &'a mut dyn Plant);

impl RetryLostFrames<'_> {
    fn until_valid(
        &mut self,
        first: Observation,
        commands: &[TendonCommand],
    ) -> Result<Observation, PlantError> {
        let mut observation = first;
        for _ in 0..MAX_REPEATS {
            if observation.valid {
                break;
            }
            observation = self.0.drive(commands)?;
        }
        if observation.valid {
            Ok(observation)
        } else {
            Err(PlantError::Unseen { steps: MAX_REPEATS })
        }
    }
}

impl Plant for RetryLostFrames<'_> {
    fn tendons(&self) -> usize {
        self.0.tendons()
    }

    fn tendon_layout(&self) -> TendonLayout {
        self.0.tendon_layout()
    }

    fn points(&self) -> Vec<String> {
        self.0.points()
    }

    fn step_s(&self) -> f64 {
        self.0.step_s()
    }

    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError> {
        let first = self.0.reset(seed)?;
        let home = vec![TendonCommand::Pull(0.0); self.tendons()];
        self.until_valid(first, &home)
    }

    fn verify(&mut self) -> Result<(), PlantError> {
        self.0.verify()
    }

    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        let first = self.0.drive(commands)?;
        self.until_valid(first, commands)
    }
}
