//! Limited-memory BFGS on all windows at once, in double precision.

use super::batch::SequenceBatch;
use super::samples::TrainingSamples;
use super::session::{EpochEnd, Epochs, Session};
use super::weights::Weights;
use super::{NetworkConfig, Stopped};
use crate::learn::LearnError;
use crate::math::optimise::Lbfgs;

/// An optimiser that sees all windows at every step; an epoch is a step.
pub(super) struct FullBatch {
    batch: SequenceBatch<f64>,
    weights: Weights<f64>,
    gradient: Weights<f64>,
    search: Lbfgs,
}

impl FullBatch {
    pub(super) fn new(
        start: &Weights<f32>,
        samples: &TrainingSamples,
        config: &NetworkConfig,
    ) -> Self {
        let double =
            |values: &[f32]| values.iter().map(|value| f64::from(*value)).collect::<Vec<f64>>();
        // A line search needs the same function at every step: no random offset of windows.
        let windows = samples.split.windows(config.window, config.stride, 0);
        let mut batch = SequenceBatch::new(start.sizes, config.window, windows.len(), config.loss);
        batch.load(&double(&samples.inputs), &double(&samples.targets), &windows);
        FullBatch {
            batch,
            weights: Weights::zeros(start.sizes),
            gradient: Weights::zeros(start.sizes),
            search: Lbfgs::new(double(&start.values)),
        }
    }
}

impl Epochs for FullBatch {
    /// Ends when no step makes the loss smaller.
    fn epoch(
        &mut self,
        session: &mut Session,
        epoch: usize,
        _: f64,
    ) -> Result<EpochEnd, LearnError> {
        let FullBatch { batch, weights, gradient, search } = self;
        let moved = search.step(&mut |at: &[f64], slope: &mut [f64]| {
            weights.values.copy_from_slice(at);
            let loss = batch.loss_and_gradient(weights, gradient);
            slope.copy_from_slice(&gradient.values);
            loss
        });
        let (training_loss, rate, stopped) = match moved {
            Some(length) => (search.value(), length, None),
            None => (search.value(), 0.0, Some(Stopped::Patience)),
        };
        if !training_loss.is_finite() {
            return Err(LearnError::Diverged { epoch });
        }
        session.updates += 1;
        let now = session.weights().values.iter_mut().zip(search.point());
        // Validation and use are in single precision; the search goes on in double.
        now.for_each(|(weight, value)| *weight = *value as f32);
        Ok(EpochEnd { training_loss, rate, stopped })
    }
}
