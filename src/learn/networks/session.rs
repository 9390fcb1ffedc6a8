//! The training of one member: epochs, early stopping, the best weights kept.

use super::config::Optimiser;
use super::full_batch::FullBatch;
use super::mini_batches::MiniBatches;
use super::samples::TrainingSamples;
use super::weights::Weights;
use super::{Epoch, Network, NetworkConfig, Stopped, Trained};
use crate::base::{Seed, interruption_point, report_share};
use crate::learn::LearnError;

/// What an epoch did.
pub(super) struct EpochEnd {
    /// Mean loss over its windows.
    pub(super) training_loss: f64,
    /// Learning rate, or length of the step.
    pub(super) rate: f64,
    /// Whether training is over, and why.
    pub(super) stopped: Option<Stopped>,
}

/// One pass of an optimiser over the windows.
pub(super) trait Epochs {
    /// Moves the session's weights.
    fn epoch(
        &mut self,
        session: &mut Session,
        epoch: usize,
        rate: f64,
    ) -> Result<EpochEnd, LearnError>;
}

/// State of a running training.
pub(super) struct Session<'a> {
    /// A network of one member, with the weights as they are now.
    network: Network,
    pub(super) samples: &'a TrainingSamples,
    pub(super) config: &'a NetworkConfig,
    pub(super) seed: Seed,
    best: Weights<f32>,
    best_mae: f64,
    best_epoch: usize,
    /// Steps of the optimiser.
    pub(super) updates: usize,
}

impl<'a> Session<'a> {
    pub(super) fn new(
        start: Network,
        samples: &'a TrainingSamples,
        config: &'a NetworkConfig,
        seed: Seed,
    ) -> Self {
        let best = start.members[0].clone();
        let (best_mae, best_epoch, updates) = (f64::INFINITY, 0, 0);
        Session { network: start, samples, config, seed, best, best_mae, best_epoch, updates }
    }

    /// The weights as they are now.
    pub(super) fn weights(&mut self) -> &mut Weights<f32> {
        &mut self.network.members[0]
    }

    pub(super) fn run(mut self) -> Result<Trained, LearnError> {
        let mut optimiser: Box<dyn Epochs> = match self.config.optimiser {
            Optimiser::Adam => Box::new(MiniBatches::new(self.network.sizes, self.config)),
            Optimiser::Lbfgs => {
                Box::new(FullBatch::new(&self.network.members[0], self.samples, self.config))
            }
        };
        let mut history = Vec::new();
        let mut rate = self.config.learning_rate;
        let mut epochs_on_plateau = 0;
        for epoch in 1..=self.config.max_epochs {
            interruption_point();
            report_share(epoch - 1, self.config.max_epochs);
            let end = optimiser.epoch(&mut self, epoch, rate)?;
            let validation_mae = self.samples.validation_mae(&self.network)?;
            let EpochEnd { training_loss, rate: learning_rate, .. } = end;
            history.push(Epoch { epoch, training_loss, validation_mae, learning_rate });
            // Before any return: the last epoch may be the best one.
            let better = self.keep_if_better(validation_mae, epoch);
            if self.has_reached(validation_mae) {
                return Ok(self.finish(history, Stopped::Reached));
            }
            if let Some(stopped) = end.stopped {
                return Ok(self.finish(history, stopped));
            }
            // The rate decays on a plateau, counted anew after each decay; training ends on the
            // epochs since the best one, which a decay does not reset.
            epochs_on_plateau = if better { 0 } else { epochs_on_plateau + 1 };
            if epochs_on_plateau >= self.config.decay_patience {
                (rate, epochs_on_plateau) = (rate * self.config.decay, 0);
            }
            if epoch - self.best_epoch >= self.config.patience {
                return Ok(self.finish(history, Stopped::Patience));
            }
        }
        Ok(self.finish(history, Stopped::Epochs))
    }

    /// Whether the validation error is now as small as the settings ask for.
    pub(super) fn reaches(&self) -> Result<bool, LearnError> {
        Ok(self.has_reached(self.samples.validation_mae(&self.network)?))
    }

    fn has_reached(&self, mae: f64) -> bool {
        self.config.stop_at_validation_mae_m.is_some_and(|target| mae <= target)
    }

    fn keep_if_better(&mut self, mae: f64, epoch: usize) -> bool {
        let better = mae < self.best_mae;
        if better {
            (self.best_mae, self.best_epoch) = (mae, epoch);
            self.best.values.copy_from_slice(&self.network.members[0].values);
        }
        better
    }

    fn finish(self, history: Vec<Epoch>, stopped: Stopped) -> Trained {
        Trained {
            network: Network { members: vec![self.best], ..self.network },
            epochs: history.len(),
            updates: self.updates,
            validation_mae: self.best_mae,
            stopped,
            history,
        }
    }
}
