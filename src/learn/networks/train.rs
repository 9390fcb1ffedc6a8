//! Training: members one after the other, each with early stopping.

use serde::{Deserialize, Serialize};

use super::samples::TrainingSamples;
use super::session::Session;
use super::weights::{Sizes, Weights};
use super::windows::Split;
use super::{Network, NetworkConfig};
use crate::base::{Rows, Seed};
use crate::learn::standardise::check_samples;
use crate::learn::{LearnError, Standardiser, exact};

/// Why a training ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
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
    /// Learning rate in this epoch; of L-BFGS the length of its step, as a share of the full one.
    #[serde(with = "exact::decimal")]
    pub learning_rate: f64,
}

/// A trained network with its training history; counts are sums over members.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trained {
    /// The network with the weights of the best validation error.
    pub network: Network,
    /// Epochs begun.
    pub epochs: usize,
    /// Steps of the optimiser.
    pub updates: usize,
    /// Best mean absolute error on the validation rows, over rows and outputs, in the outputs'
    /// unit, with the state carried through each run of validation rows as it is in use.
    #[serde(with = "exact::decimal")]
    pub validation_mae: f64,
    /// Why it ended.
    pub stopped: Stopped,
    /// Every epoch; the first member's, then the second's, ….
    pub history: Vec<Epoch>,
}

impl Network {
    /// Trains a network from random weights on `inputs` → `outputs` (one row per sample, in time
    /// order). `sequences` holds the first rows of the recordings that follow one another in the
    /// tables (empty: one recording); no window crosses such a row. The same seed gives the same
    /// bits.
    ///
    /// # Errors
    /// Numbers that are not finite, too few rows for a window and a validation, bad sequences,
    /// settings out of range, a loss that is not finite.
    pub fn train(
        inputs: &Rows,
        outputs: &Rows,
        sequences: &[usize],
        config: &NetworkConfig,
        seed: Seed,
    ) -> Result<Trained, LearnError> {
        config.check()?;
        check_samples(inputs, outputs)?;
        let split = Split::new(inputs.len(), sequences, config)?;
        // Validation rows must not decide the standardising either.
        let rows = split.training_rows();
        let (kind, history, hidden) = (config.kind, config.history(), config.hidden);
        let sizes =
            Sizes { kind, inputs: inputs.width() * history, hidden, outputs: outputs.width() };
        let random = |member| Weights::random(sizes, member_seed(seed, member).child("weights"));
        let start = Network {
            sizes,
            history,
            members: (0..config.members).map(random).collect(),
            inputs: Standardiser::fit(inputs, &rows),
            outputs: Standardiser::fit(outputs, &rows),
            recurrent: config.window > 1,
        };
        let samples = TrainingSamples::new(&start, inputs, outputs, sequences, split);
        start.train_members(&samples, config, seed)
    }

    /// Trains on from this network's weights on other samples (the paper's policy B retrains that
    /// of policy A). The network keeps its kind, its sizes, its members and its standardising;
    /// otherwise as [`Network::train`].
    ///
    /// # Errors
    /// As [`Network::train`]; [`LearnError::Shape`] for tables of other widths.
    pub fn retrain(
        &self,
        inputs: &Rows,
        outputs: &Rows,
        sequences: &[usize],
        config: &NetworkConfig,
        seed: Seed,
    ) -> Result<Trained, LearnError> {
        config.check()?;
        check_samples(inputs, outputs)?;
        LearnError::unless_shape("columns of inputs", inputs.width(), self.inputs())?;
        LearnError::unless_shape("columns of outputs", outputs.width(), self.outputs())?;
        let split = Split::new(inputs.len(), sequences, config)?;
        let start = Network { recurrent: config.window > 1, ..self.clone() };
        let samples = TrainingSamples::new(&start, inputs, outputs, sequences, split);
        start.train_members(&samples, config, seed)
    }

    /// Every member by itself, then what they are together.
    fn train_members(
        self,
        samples: &TrainingSamples,
        config: &NetworkConfig,
        seed: Seed,
    ) -> Result<Trained, LearnError> {
        let mut all: Option<Trained> = None;
        for (number, member) in self.members.iter().enumerate() {
            let alone = Network { members: vec![member.clone()], ..self.clone() };
            let mut trained =
                Session::new(alone, samples, config, member_seed(seed, number)).run()?;
            all = Some(match all {
                None => trained,
                Some(mut all) => {
                    all.network.members.append(&mut trained.network.members);
                    all.history.append(&mut trained.history);
                    all.epochs += trained.epochs;
                    all.updates += trained.updates;
                    all.stopped = all.stopped.max(trained.stopped);
                    all.validation_mae = samples.validation_mae(&all.network)?;
                    all
                }
            });
        }
        all.ok_or_else(|| LearnError::Setting {
            key: "members",
            found: "0".to_owned(),
            expected: "1 to 100",
        })
    }
}

/// The seed of a member: the first has the network's own.
fn member_seed(seed: Seed, member: usize) -> Seed {
    if member == 0 { seed } else { seed.child("member").index(member as u64) }
}
