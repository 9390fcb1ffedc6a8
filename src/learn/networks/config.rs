//! Settings of a training.

use serde::{Deserialize, Serialize};

use super::kinds::NetworkKind;
use crate::base::is_default;
use crate::learn::LearnError;

fn is_one(value: &usize) -> bool {
    *value == 1
}

/// Rows of a window in the loss.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Loss {
    /// Every row: the network is trained to predict from its first step after a reset, as in use.
    #[default]
    EveryRow,
    /// Only the last row: the rows before it are run-in.
    LastRow,
}

/// Optimiser of the weights.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Optimiser {
    /// Steps on batches of windows (Kingma & Ba 2015).
    #[default]
    Adam,
    /// Steps on all windows at once, an epoch each, by limited-memory BFGS (Liu & Nocedal 1989).
    /// `batch`, `learning_rate`, `decay_patience`, `decay` and `stop_check_updates` have no effect
    /// on it.
    Lbfgs,
}

/// Structure and training of a network. Unknown keys are refused; missing ones take the values of
/// [`Default`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkConfig {
    /// Kind of the hidden layer (paper: `elman`).
    #[serde(skip_serializing_if = "is_default")]
    pub kind: NetworkKind,
    /// Input rows of the network at a step: this row and the preceding ones. Default: 4 for
    /// `feed_forward`, 1 for the other kinds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<usize>,
    /// Number of networks trained from different random weights; the prediction is their mean.
    #[serde(skip_serializing_if = "is_one")]
    pub members: usize,
    /// Optimiser of the weights.
    #[serde(skip_serializing_if = "is_default")]
    pub optimiser: Optimiser,
    /// Hidden units (paper: 30).
    pub hidden: usize,
    /// Consecutive rows through which errors are propagated back. With 1 the recurrent weights are
    /// never used.
    pub window: usize,
    /// Rows from the start of one window to the start of the next; the first start is random in
    /// every epoch.
    pub stride: usize,
    /// Rows of a window in the loss.
    pub loss: Loss,
    /// Share of the rows for training; the rest is for validation (paper: 0.7).
    pub train_share: f64,
    /// Contiguous blocks into which the rows are cut in time order before each is split, its first
    /// rows to training and its last to validation. 1: the first 70 % and the last 30 % of the
    /// recording.
    pub split_blocks: usize,
    /// Windows per step of the optimiser.
    pub batch: usize,
    /// Adam's first learning rate.
    pub learning_rate: f64,
    /// Epochs without a better validation error after which the learning rate is multiplied by
    /// `decay`.
    pub decay_patience: usize,
    /// Factor on the learning rate.
    pub decay: f64,
    /// Epochs without a better validation error after which training stops; the best weights are
    /// kept.
    pub patience: usize,
    /// Maximum number of epochs.
    pub max_epochs: usize,
    /// Stop when the validation error (mean absolute, in the outputs' unit) reaches this value:
    /// `training: paper`.
    pub stop_at_validation_mae_m: Option<f64>,
    /// Optimiser steps between evaluations of the validation error when `stop_at_validation_mae_m`
    /// is set.
    pub stop_check_updates: usize,
}

impl Default for NetworkConfig {
    /// Chosen by validation errors on one recording (docs/method/learning.md).
    fn default() -> Self {
        NetworkConfig {
            kind: NetworkKind::default(),
            history: None,
            members: 1,
            optimiser: Optimiser::default(),
            hidden: 30,
            window: 10,
            stride: 10,
            loss: Loss::EveryRow,
            train_share: 0.7,
            split_blocks: 1,
            batch: 16,
            learning_rate: 4e-3,
            decay_patience: 20,
            decay: 0.5,
            patience: 60,
            max_epochs: 1000,
            stop_at_validation_mae_m: None,
            stop_check_updates: 5,
        }
    }
}

impl NetworkConfig {
    /// Rows of inputs that the network sees at a step.
    pub(super) fn history(&self) -> usize {
        self.history.unwrap_or(self.kind.default_history())
    }

    /// Checks that `rows` rows, with recordings that begin at `sequences`, suffice for training and
    /// validation.
    ///
    /// # Errors
    /// [`LearnError::TooFewRows`], or [`LearnError::Sequences`] for starts that do not increase.
    pub fn check_rows(&self, rows: usize, sequences: &[usize]) -> Result<(), LearnError> {
        super::windows::Split::new(rows, sequences, self).map(drop)
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`LearnError::Setting`] with the key, the value and the range.
    pub fn check(&self) -> Result<(), LearnError> {
        let counts = [
            ("history", self.history(), 100),
            ("members", self.members, 100),
            ("hidden", self.hidden, 1024),
            ("window", self.window, 1000),
            ("stride", self.stride, 1000),
            ("split_blocks", self.split_blocks, 1000),
            ("batch", self.batch, 4096),
            ("decay_patience", self.decay_patience, 1_000_000),
            ("patience", self.patience, 1_000_000),
            ("max_epochs", self.max_epochs, 1_000_000),
            ("stop_check_updates", self.stop_check_updates, 1_000_000),
        ];
        for (key, found, max) in counts {
            let expected = match max {
                100 => "1 to 100",
                1000 => "1 to 1000",
                1024 => "1 to 1024",
                4096 => "1 to 4096",
                _ => "1 to 1000000",
            };
            LearnError::unless_setting((1..=max).contains(&found), key, found, expected)?;
        }
        let ranges = [
            ("train_share", self.train_share, 0.05, 0.95, "0.05 to 0.95"),
            ("learning_rate", self.learning_rate, 1e-8, 1.0, "1e-8 to 1"),
            ("decay", self.decay, 0.01, 1.0, "0.01 to 1"),
            (
                "stop_at_validation_mae_m",
                self.stop_at_validation_mae_m.unwrap_or(1.0),
                1e-300,
                1e300,
                "above 0",
            ),
        ];
        ranges.into_iter().try_for_each(|(key, found, low, high, expected)| {
            LearnError::unless_setting(found >= low && found <= high, key, found, expected)
        })
    }
}
