//! Training: mini-batches, early stopping, the best weights kept.

use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};

use super::adam::Adam;
use super::bptt::SequenceBatch;
use super::weights::{Sizes, Weights};
use super::windows::Split;
use super::{Elman, ElmanConfig};
use crate::base::{Rows, Seed};
use crate::learn::standardise::check_samples;
use crate::learn::{LearnError, Standardiser, exact};

/// Why a training ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stopped {
    /// The validation error reached `stop_at_validation_mae_m`.
    Reached,
    /// No better validation error for `patience` epochs: converged.
    Patience,
    /// `max_epochs` are over.
    Epochs,
}

/// One epoch of a training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Epoch {
    /// Number, from 1.
    pub epoch: usize,
    /// Mean squared error over the epoch's batches, standardised.
    #[serde(with = "exact::decimal")]
    pub training_loss: f64,
    /// Mean absolute error on the validation rows, in the outputs' unit.
    #[serde(with = "exact::decimal")]
    pub validation_mae: f64,
    /// Adam's learning rate in this epoch.
    #[serde(with = "exact::decimal")]
    pub learning_rate: f64,
}

/// A trained network with its training history.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trained {
    /// The network with the weights of the best validation error.
    pub network: Elman,
    /// Epochs begun.
    pub epochs: usize,
    /// Steps of the optimiser.
    pub updates: usize,
    /// Best mean absolute error on the validation rows, over rows and outputs, in the outputs' unit, with the state
    /// carried through each run of validation rows as it is in use.
    #[serde(with = "exact::decimal")]
    pub validation_mae: f64,
    /// Why it ended.
    pub stopped: Stopped,
    /// Every epoch.
    pub history: Vec<Epoch>,
}

impl Elman {
    /// Trains a network from random weights on `inputs` → `outputs` (one row per sample, in time order). `sequences`
    /// holds the first rows of the recordings that follow one another in the tables (empty: one recording); no
    /// window crosses such a row. The same seed gives the same bits.
    ///
    /// # Errors
    /// Numbers that are not finite, too few rows for a window and a validation, bad sequences, settings out of range,
    /// a loss that is not finite.
    pub fn train(
        inputs: &Rows,
        outputs: &Rows,
        sequences: &[usize],
        config: &ElmanConfig,
        seed: Seed,
    ) -> Result<Trained, LearnError> {
        config.check()?;
        check_samples(inputs, outputs)?;
        let split = Split::new(inputs.len(), sequences, config)?;
        let rows = split.training_rows();
        let sizes = Sizes { inputs: inputs.width(), hidden: config.hidden, outputs: outputs.width() };
        let start = Elman {
            weights: Weights::random(sizes, seed.child("weights")),
            inputs: Standardiser::fit(inputs, &rows),
            outputs: Standardiser::fit(outputs, &rows),
            recurrent: config.window > 1,
        };
        Session::new(start, inputs, outputs, split, config, seed).run()
    }

    /// Trains on from this network's weights on other samples (the paper's policy B retrains that of policy A). The
    /// network keeps its size and its standardising; otherwise as [`Elman::train`].
    ///
    /// # Errors
    /// As [`Elman::train`]; [`LearnError::Shape`] for tables of other widths.
    pub fn retrain(
        &self,
        inputs: &Rows,
        outputs: &Rows,
        sequences: &[usize],
        config: &ElmanConfig,
        seed: Seed,
    ) -> Result<Trained, LearnError> {
        config.check()?;
        check_samples(inputs, outputs)?;
        let widths = [
            ("columns of inputs", inputs.width(), self.inputs()),
            ("columns of outputs", outputs.width(), self.outputs()),
        ];
        for (what, found, expected) in widths {
            if found != expected {
                return Err(LearnError::Shape { what, found, expected });
            }
        }
        let split = Split::new(inputs.len(), sequences, config)?;
        let start = Elman { recurrent: config.window > 1, ..self.clone() };
        Session::new(start, inputs, outputs, split, config, seed).run()
    }
}

/// State of a running training.
struct Session<'a> {
    network: Elman,
    config: &'a ElmanConfig,
    seed: Seed,
    split: Split,
    /// Standardised training tables, row-major.
    inputs: Vec<f32>,
    targets: Vec<f32>,
    /// Validation rows, one table per run.
    held_out: Vec<(Rows, Rows)>,
    batch: SequenceBatch<f32>,
    gradient: Weights<f32>,
    adam: Adam<f32>,
    best: Weights<f32>,
    best_mae: f64,
    best_epoch: usize,
    updates: usize,
}

impl<'a> Session<'a> {
    fn new(start: Elman, inputs: &Rows, outputs: &Rows, split: Split, config: &'a ElmanConfig, seed: Seed) -> Self {
        let table = |rows: &Rows, by: &Standardiser| -> Vec<f32> {
            rows.values().iter().enumerate().map(|(i, v)| by.apply(i % rows.width(), *v) as f32).collect()
        };
        let pick = |rows: &Rows, run: &std::ops::Range<usize>| rows.select(&run.clone().collect::<Vec<_>>());
        Session {
            config,
            seed,
            inputs: table(inputs, &start.inputs),
            targets: table(outputs, &start.outputs),
            held_out: split.validate.iter().map(|run| (pick(inputs, run), pick(outputs, run))).collect(),
            split,
            batch: SequenceBatch::new(start.weights.sizes, config.window, config.batch, config.loss),
            gradient: Weights::zeros(start.weights.sizes),
            adam: Adam::new(start.weights.values.len()),
            best: start.weights.clone(),
            best_mae: f64::INFINITY,
            best_epoch: 0,
            updates: 0,
            network: start,
        }
    }

    fn run(mut self) -> Result<Trained, LearnError> {
        let mut history = Vec::new();
        let mut rate = self.config.learning_rate;
        let mut waited = 0;
        for epoch in 1..=self.config.max_epochs {
            let (training_loss, reached) = self.epoch(epoch, rate)?;
            let validation_mae = self.validate()?;
            history.push(Epoch { epoch, training_loss, validation_mae, learning_rate: rate });
            let better = self.keep_if_better(validation_mae, epoch);
            if reached || self.reached(validation_mae) {
                return Ok(self.finish(history, Stopped::Reached));
            }
            waited = if better { 0 } else { waited + 1 };
            if waited >= self.config.decay_patience {
                (rate, waited) = (rate * self.config.decay, 0);
            }
            if epoch - self.best_epoch >= self.config.patience {
                return Ok(self.finish(history, Stopped::Patience));
            }
        }
        Ok(self.finish(history, Stopped::Epochs))
    }

    /// One pass over the windows; mean loss, and whether the target error was reached on the way.
    fn epoch(&mut self, epoch: usize, rate: f64) -> Result<(f64, bool), LearnError> {
        use rand::RngExt;
        let mut rng = self.seed.child("epochs").index(epoch as u64).rng();
        let offset = rng.random_range(0..self.config.stride);
        let mut windows = self.split.windows(self.config.window, self.config.stride, offset);
        windows.shuffle(&mut rng);
        let mut sum = 0.0;
        for starts in windows.chunks(self.config.batch) {
            self.batch.load(&self.inputs, &self.targets, starts);
            let loss = self.batch.loss_and_gradient(&self.network.weights, &mut self.gradient);
            if !loss.is_finite() {
                return Err(LearnError::Diverged { epoch });
            }
            sum += f64::from(loss) * starts.len() as f64;
            self.adam.step(&mut self.network.weights.values, &self.gradient.values, rate);
            self.updates += 1;
            let look = self.config.stop_at_validation_mae_m.is_some()
                && self.updates.is_multiple_of(self.config.stop_check_updates);
            if look {
                let mae = self.validate()?;
                if self.reached(mae) {
                    return Ok((sum / windows.len() as f64, true));
                }
            }
        }
        Ok((sum / windows.len() as f64, false))
    }

    fn reached(&self, mae: f64) -> bool {
        self.config.stop_at_validation_mae_m.is_some_and(|target| mae <= target)
    }

    fn keep_if_better(&mut self, mae: f64, epoch: usize) -> bool {
        let better = mae < self.best_mae;
        if better {
            (self.best_mae, self.best_epoch) = (mae, epoch);
            self.best.values.copy_from_slice(&self.network.weights.values);
        }
        better
    }

    /// Mean absolute error on the validation rows, in the outputs' unit.
    fn validate(&self) -> Result<f64, LearnError> {
        let (mut sum, mut count) = (0.0, 0);
        for (inputs, outputs) in &self.held_out {
            let answers = self.network.predict_rows(inputs, &[])?;
            sum += answers.values().iter().zip(outputs.values()).map(|(a, b)| (a - b).abs()).sum::<f64>();
            count += outputs.values().len();
        }
        Ok(sum / f64::from(u32::try_from(count).unwrap_or(u32::MAX)))
    }

    fn finish(self, history: Vec<Epoch>, stopped: Stopped) -> Trained {
        Trained {
            network: Elman { weights: self.best, ..self.network },
            epochs: history.len(),
            updates: self.updates,
            validation_mae: self.best_mae,
            stopped,
            history,
        }
    }
}
