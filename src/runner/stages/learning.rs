//! Networks and Gaussian processes.

use super::{Added, Stages, status, stops};
use crate::base::Rows;
use crate::data::rows::GpRow;
use crate::learn::gp::Gp;
use crate::learn::rnn::{Elman, ElmanConfig, Trained};
use crate::policies::{ElmanForward, GpError};
use crate::runner::graph::{Failure, Handle, Inputs, StageKind};
use crate::runner::source_digest::LEARN;
use crate::specs::{GeneratedStart, Training};
use crate::tasks::{self, SimulatedBy, Transitions};
use std::sync::Arc;

const FORWARD: StageKind = StageKind { name: "train_forward", sources: LEARN, cost_ms: 2000 };
const INVERSE: StageKind = StageKind { name: "train_inverse", sources: LEARN, cost_ms: 1000 };
const GENERATED: StageKind = StageKind { name: "train_inverse_b", sources: LEARN, cost_ms: 1000 };
const REAL: StageKind = StageKind { name: "train_pi_real", sources: LEARN, cost_ms: 1000 };
const GP_SCORE: StageKind = StageKind { name: "gp_score", sources: LEARN, cost_ms: 50 };
const GP: StageKind = StageKind { name: "gp_fit", sources: LEARN, cost_ms: 100 };
/// All of this file.
pub(super) const KINDS: [StageKind; 6] = [FORWARD, INVERSE, GENERATED, REAL, GP_SCORE, GP];

impl Stages<'_> {
    /// The forward model of eq. (17): (u_i, x_i) → x_{i+1}.
    pub(crate) fn forward(&mut self, training: &Training) -> Added<Trained> {
        self.once((FORWARD.name, stops(training), 0), |stages| stages.add_forward(training))
    }

    fn add_forward(&mut self, training: &Training) -> Added<Trained> {
        let samples = self.explore()?;
        let config = self.network(training.forward_mae_m);
        let seed = self.seed.child("forward");
        let label = self.label("forward network");
        self.graph.stage(FORWARD, label, &(config.clone(), seed.0), &[samples.number()], move |given| {
            let samples = given.get(samples)?;
            let inputs = beside(&samples.pulls_m, &samples.from_m);
            Elman::train(&inputs, &samples.to_m, &samples.starts, &config, seed).map_err(status)
        })
    }

    /// The inverse mapping of eq. (21) from simulated data: (x_i, x_{i+1}) → u_i.
    pub(crate) fn inverse(&mut self, training: &Training) -> Added<Trained> {
        self.once((INVERSE.name, stops(training), 0), |stages| stages.add_inverse(training))
    }

    fn add_inverse(&mut self, training: &Training) -> Added<Trained> {
        let samples = self.explore()?;
        let config = self.network(training.inverse_mae_m);
        let seed = self.seed.child("inverse");
        let label = self.label("inverse network");
        self.graph.stage(INVERSE, label, &(config.clone(), seed.0), &[samples.number()], move |given| {
            let samples = given.get(samples)?;
            let inputs = beside(&samples.from_m, &samples.to_m);
            Elman::train(&inputs, &samples.pulls_m, &samples.starts, &config, seed).map_err(status)
        })
    }

    /// The inverse mapping from the first `points` real data (π_real).
    pub(crate) fn pi_real(&mut self, training: &Training, points: usize) -> Added<Trained> {
        self.once((REAL.name, stops(training), points), |stages| stages.add_pi_real(training, points))
    }

    fn add_pi_real(&mut self, training: &Training, points: usize) -> Added<Trained> {
        let samples = self.replay()?;
        let config = self.network(training.pi_real_mae_m);
        let seed = self.seed.child("pi_real");
        let label = self.label(&format!("real network, {points} points"));
        self.graph.stage(REAL, label, &(config.clone(), points, seed.0), &[samples.number()], move |given| {
            let samples = given.get(samples)?.first(points);
            let inputs = beside(&samples.from_m, &samples.to_m);
            Elman::train(&inputs, &samples.pulls_m, &samples.starts, &config, seed).map_err(status)
        })
    }

    /// The Gaussian process of eq. (20) on one point of each of `points` clusters.
    pub(crate) fn gp(&mut self, training: &Training, points: usize) -> Added<Gp> {
        self.once((GP.name, stops(training), points), |stages| stages.add_gp(training, points))
    }

    fn add_gp(&mut self, training: &Training, points: usize) -> Added<Gp> {
        let (pool, network) = (self.gp_pool()?, self.simulating_network(training)?);
        let inputs: Vec<usize> = [pool.number()].into_iter().chain(network.map(Handle::number)).collect();
        let (config, seed) = (self.spec.gp.clone(), self.seed.child("gp"));
        let label = self.label(&format!("Gaussian process, {points} points"));
        self.graph.stage(GP, label, &(config.clone(), points, seed.0), &inputs, move |given| {
            let pool = given.get(pool)?;
            let points_by = |steps: &Transitions| pool.points_by(steps);
            let all = network.map(|network| simulated(given, network, &pool.steps)).transpose()?;
            let all = all.as_ref().map_or_else(|| pool.points(), points_by);
            let chosen = tasks::one_of_each_cluster(all.inputs.len(), points, seed).map_err(status)?;
            let chosen = all.select(&chosen);
            Gp::fit(&chosen.inputs, &chosen.errors_m, &config).map_err(status)
        })
    }

    /// How good that process is; the row's seed and training are filled in by whoever publishes it. A stage of its own, so that
    /// publishing holds no process in memory.
    pub(crate) fn gp_score(&mut self, training: &Training, points: usize) -> Added<GpRow> {
        let gp = self.gp(training, points)?;
        let label = self.label(&format!("score of the process on {points} points"));
        self.graph.stage(GP_SCORE, label, &(), &[gp.number()], move |given| Ok(gp_row(given.get(gp)?)))
    }

    /// The inverse mapping from generated data (eq. 24), with the Gaussian process on `points` points.
    pub(crate) fn generated(&mut self, training: &Training, points: usize) -> Added<Trained> {
        self.once((GENERATED.name, stops(training), points), |stages| stages.add_generated(training, points))
    }

    fn add_generated(&mut self, training: &Training, points: usize) -> Added<Trained> {
        let (samples, gp, start) = (self.explore()?, self.gp(training, points)?, self.inverse(training)?);
        let network = self.simulating_network(training)?;
        let (config, seed) = (self.network(training.inverse_b_mae_m), self.seed.child("inverse_b"));
        let warm = self.spec.generated_start == GeneratedStart::Trained;
        let mut inputs = vec![samples.number(), gp.number()];
        inputs.extend(warm.then_some(start.number()));
        inputs.extend(network.map(Handle::number));
        let label = self.label(&format!("generated-data network, {points} points"));
        self.graph.stage(GENERATED, label, &(config.clone(), seed.0), &inputs, move |given| {
            let samples = {
                let samples = given.get(samples)?;
                let error = GpError::new(given.get(gp)?.clone(), samples.pulls_m.width()).map_err(status)?;
                let simulated = network.map(|network| simulated(given, network, samples)).transpose()?;
                tasks::correct_samples(simulated.as_ref().unwrap_or(samples), &error).map_err(status)?
            };
            let inputs = beside(&samples.from_m, &samples.to_m);
            let (outputs, starts) = (&samples.pulls_m, &samples.starts);
            let trained = if warm {
                given.get(start)?.network.retrain(&inputs, outputs, starts, &config, seed)
            } else {
                Elman::train(&inputs, outputs, starts, &config, seed)
            };
            trained.map_err(status)
        })
    }

    /// The forward network where p_sim comes from it, and nothing where it comes from the rod.
    fn simulating_network(&mut self, training: &Training) -> Result<Option<Handle<Trained>>, Failure> {
        match self.spec.gp_points.p_sim {
            SimulatedBy::Rod => Ok(None),
            SimulatedBy::Network => self.forward(training).map(Some),
        }
    }

    fn network(&self, stop_at_validation_mae_m: Option<f64>) -> ElmanConfig {
        ElmanConfig { stop_at_validation_mae_m, ..self.spec.network.clone() }
    }
}

/// The commands of a recording as the forward network plays them.
fn simulated(given: &Inputs, network: Handle<Trained>, samples: &Transitions) -> Result<Transitions, String> {
    let network = Arc::new(given.get(network)?.network.clone());
    let mut model = ElmanForward::new(network, samples.pulls_m.width()).map_err(status)?;
    tasks::rollout(samples, &mut model).map_err(status)
}

/// The columns of two tables side by side.
fn beside(left: &Rows, right: &Rows) -> Rows {
    let mut rows = Rows::new(left.width() + right.width());
    for (left, right) in left.iter().zip(right.iter()) {
        rows.push(&[left, right].concat());
    }
    rows
}

fn gp_row(gp: &Gp) -> GpRow {
    let noise = gp.noise_std();
    let noise_m = |axis: usize| noise.get(axis).copied().unwrap_or(f64::NAN);
    GpRow {
        seed: 0,
        training: String::new(),
        points: gp.points() as u64,
        kernel: gp.config().kernel.0.name().to_owned(),
        cross_validation_mae_m: crate::math::summary::mean(&gp.cross_validation_mae()),
        log_marginal_likelihood: gp.log_marginal_likelihood().iter().sum(),
        noise_x_m: noise_m(0),
        noise_y_m: noise_m(1),
        noise_z_m: noise_m(2),
    }
}
