//! The stages of networks and Gaussian processes.

use super::sizes::GP_POINTS;
use super::{Added, Stages, stops};
use crate::learn::gp::Gp;
use crate::learn::networks::{NetworkConfig, Trained};
use crate::policies::{FORWARD, INVERSE, NetworkDescription, TrainingData};
use crate::rows::experiment::{GpCoverage, GpLeftOut, GpScore};
use crate::runner::graph::failure::Failure;
use crate::runner::graph::stage::{Handle, StageKind};
use crate::runner::jobs::learning::gaussian_process::{GP, GP_SCORE, GpParams};
use crate::runner::jobs::learning::generated_network::train_generated;
use crate::runner::jobs::learning::gp_coverage::{CoverageParams, GP_COVERAGE};
use crate::runner::jobs::learning::gp_leave_one_out::GP_LEAVE_ONE_OUT;
use crate::runner::jobs::learning::imitating_network::{ImitationParams, train_imitating};
use crate::runner::jobs::learning::networks::{NetworkParams, train};
use crate::specs::{GeneratedStart, Training};
use crate::tasks::SimulatedBy;

impl Stages<'_> {
    /// A network that a policy describes; `points` are those of the data that it depends on.
    pub(crate) fn network(
        &mut self,
        network: &'static NetworkDescription,
        training: &Training,
        points: usize,
    ) -> Added<Trained> {
        self.once((network.stage, stops(training), points), |stages| {
            stages.add_network(network, training, points)
        })
    }

    fn add_network(
        &mut self,
        network: &'static NetworkDescription,
        training: &Training,
        points: usize,
    ) -> Added<Trained> {
        let label = if points == 0 {
            network.label.to_owned()
        } else {
            format!("{}, {points} points", network.label)
        };
        let (label, params) = (self.label(&label), self.network_params(network, training, points));
        match network.data {
            TrainingData::Simulated => {
                let samples = self.explore()?;
                self.graph.stage(&train(network), label, params, samples)
            }
            TrainingData::Real => {
                let samples = self.replay()?;
                self.graph.stage(&train(network), label, params, samples)
            }
            TrainingData::Generated => {
                let (samples, gp) = (self.explore()?, self.gp(training, points)?);
                let start =
                    network.start.map(|start| self.network(start, training, 0)).transpose()?;
                let warm = self.spec.generated_start == GeneratedStart::Trained;
                let inputs =
                    (samples, gp, start.filter(|_| warm), self.simulating_network(training)?);
                self.graph.stage(&train_generated(network), label, params, inputs)
            }
            TrainingData::Randomised => {
                let start = self.network(network.start.unwrap_or(&INVERSE), training, 0)?;
                let (model, explore) = (self.parts.model.clone(), self.spec.explore);
                let (policies, step_s) = (self.parts.policies.clone(), self.step_s());
                let params = ImitationParams { network: params, model, explore, policies, step_s };
                self.graph.stage(&train_imitating(network), label, params, start)
            }
        }
    }

    /// The Gaussian process of eq. (20) on one point of each of `points` clusters.
    pub(crate) fn gp(&mut self, training: &Training, points: usize) -> Added<Gp> {
        self.once((GP.kind.name, stops(training), points), |stages| {
            let inputs = (stages.gp_pool()?, stages.simulating_network(training)?);
            let label = stages.label(&format!("Gaussian process, {points} points"));
            stages.graph.set_size(GP.kind.name, (points as f64 / GP_POINTS).powi(3));
            stages.graph.stage(&GP, label, stages.gp_params(points), inputs)
        })
    }

    /// Which points a process has and how it is fitted.
    pub(super) fn gp_params(&self, points: usize) -> GpParams {
        GpParams { config: self.spec.gp_config(), points, seed: self.seed.child("gp").0 }
    }

    /// How good that process is; the row's seed and training are filled in by whoever publishes it.
    pub(crate) fn gp_score(&mut self, training: &Training, points: usize) -> Added<GpScore> {
        let gp = self.gp(training, points)?;
        self.graph.stage(
            &GP_SCORE,
            self.label(&format!("score of the process on {points} points")),
            (),
            gp,
        )
    }

    /// How often its intervals cover what was measured.
    pub(crate) fn gp_coverage(
        &mut self,
        training: &Training,
        points: usize,
    ) -> Added<Vec<GpCoverage>> {
        let inputs =
            (self.gp_pool()?, self.simulating_network(training)?, self.gp(training, points)?);
        let params = CoverageParams {
            gp: self.gp_params(points),
            shares: self.spec.runs.gp_coverage.clone(),
        };
        let label = self.label(&format!("intervals of the process on {points} points"));
        self.graph.stage(&GP_COVERAGE, label, params, inputs)
    }

    /// How it foretells each of its points from the others.
    pub(crate) fn gp_leave_one_out(
        &mut self,
        training: &Training,
        points: usize,
    ) -> Added<Vec<GpLeftOut>> {
        let (gp, shares) = (self.gp(training, points)?, self.spec.runs.gp_leave_one_out.clone());
        let label =
            self.label(&format!("points of the process on {points} points, left out one by one"));
        self.graph.stage(&GP_LEAVE_ONE_OUT, label, shares, gp)
    }

    /// The forward network where p_sim comes from it, and nothing where it comes from the rod.
    fn simulating_network(
        &mut self,
        training: &Training,
    ) -> Result<Option<Handle<Trained>>, Failure> {
        match self.spec.gp_points.p_sim {
            SimulatedBy::Rod => Ok(None),
            SimulatedBy::Network => self.network(&FORWARD, training, 0).map(Some),
        }
    }

    pub(super) fn network_params(
        &self,
        network: &NetworkDescription,
        training: &Training,
        points: usize,
    ) -> NetworkParams {
        NetworkParams {
            config: NetworkConfig {
                stop_at_validation_mae_m: training.stop_m(network),
                ..self.spec.network.clone()
            },
            inputs: network.inputs,
            outputs: network.outputs,
            points: (network.data == TrainingData::Real).then_some(points),
            seed: self.seed.child(network.name).0,
        }
    }
}

/// The kind of the stage that trains a network.
pub(super) fn kind(network: &NetworkDescription) -> StageKind {
    match network.data {
        TrainingData::Simulated | TrainingData::Real => train(network).kind,
        TrainingData::Generated => train_generated(network).kind,
        TrainingData::Randomised => train_imitating(network).kind,
    }
}
