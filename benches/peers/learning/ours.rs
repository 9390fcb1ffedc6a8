//! Our own learning on the tasks.

use std::collections::BTreeMap;

use spinebench::base::Seed;
use spinebench::learn::gp::{Gp, GpConfig};
use spinebench::learn::networks::{Network, NetworkConfig, Stopped};

use super::product;
use super::samples::{ProcessSamples, Samples};
use super::task::{Outcome, Task};
use crate::clock;

/// Mean absolute error on the held-out rows that a network is trained to, metres.
pub const TARGET_M: f64 = 0.0002;
/// Epochs that are timed together.
const EPOCHS: usize = 4;

/// Ours, with the processes that were fitted last.
pub struct Ours<'a> {
    samples: &'a Samples,
    fitted: BTreeMap<usize, Gp>,
}

impl<'a> Ours<'a> {
    pub fn new(samples: &'a Samples) -> Ours<'a> {
        Ours { samples, fitted: BTreeMap::new() }
    }

    /// Carries out a task.
    ///
    /// # Errors
    /// Why it could not be.
    pub fn run(&mut self, task: Task, round: u64) -> Result<Outcome, String> {
        match task.name {
            "fit" => self.fit(task.size),
            "evaluation" => self.evaluation(task.size),
            "predict_one" => {
                let (gp, own) = (self.fitted(task.size)?, self.of(task.size)?);
                let query = own.queries.row(17);
                clock::mean(|| gp.predict(query)).into_outcome()
            }
            "predict_many" => {
                let (gp, own) = (self.fitted(task.size)?, self.of(task.size)?);
                clock::mean(|| gp.predict_rows(&own.queries)).into_outcome()
            }
            "epoch" => self.epoch(round),
            "until_error" => self.until_error(round),
            "product_f64" => Ok(Outcome::of(product::cpu_s(task.size, true))),
            "product_f32" => Ok(Outcome::of(product::cpu_s(task.size, false))),
            other => Err(format!("no task `{other}`")),
        }
    }

    fn of(&self, size: usize) -> Result<&'a ProcessSamples, String> {
        self.samples
            .processes
            .iter()
            .find(|own| own.size == size)
            .ok_or_else(|| format!("no samples of size {size}"))
    }

    fn fitted(&self, size: usize) -> Result<&Gp, String> {
        self.fitted.get(&size).ok_or_else(|| format!("not fitted at size {size}"))
    }

    /// From one start; ours begins on a hundred rows, as it does by default.
    fn fit(&mut self, size: usize) -> Result<Outcome, String> {
        let own = self.of(size)?;
        let config = GpConfig { starts: 1, ..GpConfig::default() };
        let (gp, cpu_s) = clock::mean(|| Gp::fit(&own.inputs, &own.outputs, &config));
        let gp = gp.map_err(|error| error.to_string())?;
        let mean = gp.mean_rows(&own.queries).map_err(|error| error.to_string())?;
        let scaled = |(i, (mean, truth)): (usize, (&f64, &f64))| {
            ((mean - truth) * own.scale_m[i % 3]).powi(2)
        };
        let square: f64 =
            mean.values().iter().zip(own.truth.values()).enumerate().map(scaled).sum();
        let outcome = Outcome {
            cpu_s,
            likelihood: gp.log_marginal_likelihood().iter().sum(),
            evaluations: gp.evaluations() as f64,
            error_m: (square / mean.values().len() as f64).sqrt(),
        };
        self.fitted.insert(size, gp);
        Ok(outcome)
    }

    /// One evaluation of the likelihood with its gradient: a fit whose every evaluation is on all
    /// rows, over their number.
    fn evaluation(&self, size: usize) -> Result<Outcome, String> {
        let own = self.of(size)?;
        let config = GpConfig { starts: 1, start_rows: size, ..GpConfig::default() };
        let (gp, cpu_s) = clock::mean(|| Gp::fit(&own.inputs, &own.outputs, &config));
        let evaluations = gp.map_err(|error| error.to_string())?.evaluations();
        Ok(Outcome { evaluations: evaluations as f64, ..Outcome::of(cpu_s / evaluations as f64) })
    }

    fn epoch(&self, round: u64) -> Result<Outcome, String> {
        let config = NetworkConfig { max_epochs: EPOCHS, ..settings() };
        let (trained, cpu_s) = self.train(&config, round);
        let trained = trained.map_err(|error| error.to_string())?;
        let last = trained.history.last().map_or(f64::NAN, |epoch| epoch.validation_mae);
        Ok(Outcome { error_m: last, ..Outcome::of(cpu_s / EPOCHS as f64) })
    }

    fn until_error(&self, round: u64) -> Result<Outcome, String> {
        let config = NetworkConfig { stop_at_validation_mae_m: Some(TARGET_M), ..settings() };
        let (trained, cpu_s) = self.train(&config, round);
        let trained = trained.map_err(|error| error.to_string())?;
        let error_m = trained.validation_mae;
        if trained.stopped != Stopped::Reached {
            return Err(format!("still {:.3} mm after {} epochs", 1e3 * error_m, trained.epochs));
        }
        Ok(Outcome { evaluations: trained.epochs as f64, error_m, ..Outcome::of(cpu_s) })
    }

    /// The network's outputs in metres, so that its errors are.
    fn train(
        &self,
        config: &NetworkConfig,
        round: u64,
    ) -> (Result<spinebench::learn::networks::Trained, spinebench::learn::LearnError>, f64) {
        let own = &self.samples.network;
        clock::mean(|| Network::train(&own.inputs, &own.outputs_m, &[], config, Seed(round)))
    }
}

/// A window from every row, batches of 64, one learning rate; the error is looked at after every
/// epoch.
fn settings() -> NetworkConfig {
    NetworkConfig {
        stride: 1,
        batch: 64,
        decay: 1.0,
        patience: 1000,
        stop_check_updates: 1_000_000,
        ..NetworkConfig::default()
    }
}

/// A time of which only the failure matters besides.
trait IntoOutcome {
    fn into_outcome(self) -> Result<Outcome, String>;
}

impl<R, E: std::fmt::Display> IntoOutcome for (Result<R, E>, f64) {
    fn into_outcome(self) -> Result<Outcome, String> {
        self.0.map(|_| Outcome::of(self.1)).map_err(|error| error.to_string())
    }
}
