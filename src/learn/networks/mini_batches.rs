//! Adam on batches of windows.

use rand::RngExt;
use rand::seq::SliceRandom;

use super::adam::Adam;
use super::batch::SequenceBatch;
use super::session::{EpochEnd, Epochs, Session};
use super::weights::{Sizes, Weights};
use super::{NetworkConfig, Stopped};
use crate::base::interruption_point;
use crate::learn::LearnError;

/// An optimiser that sees some windows at a time, in an order drawn anew in every epoch.
pub(super) struct MiniBatches {
    batch: SequenceBatch<f32>,
    gradient: Weights<f32>,
    adam: Adam<f32>,
}

impl MiniBatches {
    pub(super) fn new(sizes: Sizes, config: &NetworkConfig) -> Self {
        MiniBatches {
            batch: SequenceBatch::new(sizes, config.window, config.batch, config.loss),
            gradient: Weights::zeros(sizes),
            adam: Adam::new(sizes.len()),
        }
    }
}

impl Epochs for MiniBatches {
    /// Ends early once the validation error is as small as the settings ask for.
    fn epoch(
        &mut self,
        session: &mut Session,
        epoch: usize,
        rate: f64,
    ) -> Result<EpochEnd, LearnError> {
        let config = session.config;
        let mut rng = session.seed.child("epochs").index(epoch as u64).rng();
        // Another offset in each epoch: every row stands at every place of a window in time.
        let offset = rng.random_range(0..config.stride);
        let mut windows = session.samples.split.windows(config.window, config.stride, offset);
        windows.shuffle(&mut rng);
        let mut sum = 0.0;
        let end = |sum: f64, stopped| EpochEnd {
            training_loss: sum / windows.len() as f64,
            rate,
            stopped,
        };
        for starts in windows.chunks(config.batch) {
            interruption_point();
            self.batch.load(&session.samples.inputs, &session.samples.targets, starts);
            let loss = self.batch.loss_and_gradient(session.weights(), &mut self.gradient);
            if !loss.is_finite() {
                return Err(LearnError::Diverged { epoch });
            }
            // The last batch may be smaller: the mean is weighted by windows.
            sum += f64::from(loss) * starts.len() as f64;
            self.adam.step(&mut session.weights().values, &self.gradient.values, rate);
            session.updates += 1;
            let has_target = config.stop_at_validation_mae_m.is_some();
            if has_target
                && session.updates.is_multiple_of(config.stop_check_updates)
                && session.reaches()?
            {
                return Ok(end(sum, Some(Stopped::Reached)));
            }
        }
        Ok(end(sum, None))
    }
}
