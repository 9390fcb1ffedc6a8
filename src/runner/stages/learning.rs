//! The stages of networks and Gaussian processes.

use super::{Added, Stages, stops};
use crate::data::rows::GpRow;
use crate::learn::gp::Gp;
use crate::learn::rnn::{ElmanConfig, Trained};
use crate::runner::failure::Failure;
use crate::runner::jobs::gaussian_process::{GP, GP_SCORE, GpParams};
use crate::runner::jobs::generated_network::GENERATED;
use crate::runner::jobs::networks::{FORWARD, INVERSE, NetworkParams, REAL};
use crate::runner::stage::Handle;
use crate::specs::{GeneratedStart, Training};
use crate::tasks::SimulatedBy;

impl Stages<'_> {
    /// The forward model of eq. (17): (u_i, x_i) → x_{i+1}.
    pub(crate) fn forward(&mut self, training: &Training) -> Added<Trained> {
        self.once((FORWARD.kind.name, stops(training), 0), |stages| {
            let samples = stages.explore()?;
            let params = stages.network(training.forward_mae_m, "forward");
            stages.graph.stage(&FORWARD, stages.label("forward network"), params, samples)
        })
    }

    /// The inverse mapping of eq. (21) from simulated data: (x_i, x_{i+1}) → u_i.
    pub(crate) fn inverse(&mut self, training: &Training) -> Added<Trained> {
        self.once((INVERSE.kind.name, stops(training), 0), |stages| {
            let samples = stages.explore()?;
            let params = stages.network(training.inverse_mae_m, "inverse");
            stages.graph.stage(&INVERSE, stages.label("inverse network"), params, samples)
        })
    }

    /// The inverse mapping from the first `points` real data (π_real).
    pub(crate) fn pi_real(&mut self, training: &Training, points: usize) -> Added<Trained> {
        self.once((REAL.kind.name, stops(training), points), |stages| {
            let samples = stages.replay()?;
            let params = (points, stages.network(training.pi_real_mae_m, "pi_real"));
            stages.graph.stage(&REAL, stages.label(&format!("real network, {points} points")), params, samples)
        })
    }

    /// The Gaussian process of eq. (20) on one point of each of `points` clusters.
    pub(crate) fn gp(&mut self, training: &Training, points: usize) -> Added<Gp> {
        self.once((GP.kind.name, stops(training), points), |stages| {
            let inputs = (stages.gp_pool()?, stages.simulating_network(training)?);
            let params = GpParams { config: stages.spec.gp.clone(), points, seed: stages.seed.child("gp").0 };
            stages.graph.stage(&GP, stages.label(&format!("Gaussian process, {points} points")), params, inputs)
        })
    }

    /// How good that process is; the row's seed and training are filled in by whoever publishes it.
    pub(crate) fn gp_score(&mut self, training: &Training, points: usize) -> Added<GpRow> {
        let gp = self.gp(training, points)?;
        self.graph.stage(&GP_SCORE, self.label(&format!("score of the process on {points} points")), (), gp)
    }

    /// The inverse mapping from generated data (eq. 24), with the Gaussian process on `points` points.
    pub(crate) fn generated(&mut self, training: &Training, points: usize) -> Added<Trained> {
        self.once((GENERATED.kind.name, stops(training), points), |stages| {
            let (samples, gp, start) = (stages.explore()?, stages.gp(training, points)?, stages.inverse(training)?);
            let warm = stages.spec.generated_start == GeneratedStart::Trained;
            let inputs = (samples, gp, warm.then_some(start), stages.simulating_network(training)?);
            let params = stages.network(training.inverse_b_mae_m, "inverse_b");
            let label = stages.label(&format!("generated-data network, {points} points"));
            stages.graph.stage(&GENERATED, label, params, inputs)
        })
    }

    /// The forward network where p_sim comes from it, and nothing where it comes from the rod.
    fn simulating_network(&mut self, training: &Training) -> Result<Option<Handle<Trained>>, Failure> {
        match self.spec.gp_points.p_sim {
            SimulatedBy::Rod => Ok(None),
            SimulatedBy::Network => self.forward(training).map(Some),
        }
    }

    fn network(&self, stop_at_validation_mae_m: Option<f64>, seed: &str) -> NetworkParams {
        let config = ElmanConfig { stop_at_validation_mae_m, ..self.spec.network.clone() };
        NetworkParams { config, seed: self.seed.child(seed).0 }
    }
}
