//! Networks trained along their own ways, on robots that differ from the model at random.

use super::networks::{NetworkParams, columns};
use crate::base::{Policy, Seed};
use crate::benchmark::Population;
use crate::learn::networks::{Network, Trained};
use crate::policies::{
    self, DAGGER, DaggerOptions, NetworkDescription, PolicyOptions, PolicyParts,
};
use crate::runner::graph::stage::{Handle, Stage, StageKind};
use crate::runner::jobs::parts::identified::Identified;
use crate::runner::jobs::parts::shared_part::SharedPart;
use crate::specs::PlantSpec;
use crate::tasks::{self, ExploreOptions, Transitions};
use std::sync::Arc;

/// The training of a network that begins with the inverse network of the model.
pub(crate) fn train_imitating(
    network: &NetworkDescription,
) -> Stage<ImitationParams, Handle<Trained>, Trained> {
    Stage {
        kind: StageKind { name: network.stage, module: module_path!(), cost_ms: 60_000 },
        job: |params, start| {
            // DAgger (Ross, Gordon & Bagnell 2011): each round adds what the latest network meets,
            // and trains on all.
            let (mut trained, mut samples) = (start.clone(), Vec::new());
            for round in 0..params.options().rounds as u64 {
                samples.extend(params.record(
                    &trained.network,
                    Seed(params.network.seed).child("round").index(round),
                )?);
                let all = Transitions::concat(&samples);
                let (inputs, outputs) =
                    (columns(&all, params.network.inputs), columns(&all, params.network.outputs));
                let (config, seed) = (&params.network.config, Seed(params.network.seed));
                let retrained =
                    trained.network.retrain(&inputs, &outputs, &all.starts, config, seed);
                trained = retrained.map_err(|error| error.to_string())?;
            }
            Ok(trained)
        },
    }
}

/// Parameters of the training.
#[derive(serde::Serialize)]
pub(crate) struct ImitationParams {
    pub(crate) network: NetworkParams,
    /// The robots differ from this one.
    pub(crate) model: Identified,
    pub(crate) explore: ExploreOptions,
    pub(crate) policies: SharedPart<PolicyOptions>,
    pub(crate) step_s: f64,
}

impl ImitationParams {
    fn options(&self) -> &DaggerOptions {
        &self.policies.dagger
    }

    /// What a round records with a network in charge; robots that cannot be simulated are left out.
    fn record(&self, network: &Network, seed: Seed) -> Result<Vec<Transitions>, String> {
        let mut policy = self.policy(network)?;
        let robots =
            (0..self.options().robots as u64).map(|robot| seed.child("robot").index(robot));
        let recorded: Vec<Transitions> =
            robots.filter_map(|seed| self.record_robot(policy.as_mut(), seed).ok()).collect();
        if recorded.is_empty() {
            Err("none of the drawn robots could be simulated".to_owned())
        } else {
            Ok(recorded)
        }
    }

    fn policy(&self, network: &Network) -> Result<Box<dyn Policy>, String> {
        let entry = policies::find(DAGGER.name).ok_or("no policy of this network")?;
        let parts = PolicyParts::default().with_network(&DAGGER, Arc::new(network.clone()));
        let parts = parts.map_err(|error| error.to_string())?;
        policies::build(entry, parts, &self.policies).map_err(|error| error.to_string())
    }

    /// The ways to the targets of one robot.
    fn record_robot(&self, policy: &mut dyn Policy, seed: Seed) -> Result<Transitions, String> {
        let PlantSpec::Simulated(model) = self.model.spec() else {
            return Err("robots with different parameters require a simulated model".to_owned());
        };
        let options = self.options();
        let population = Population {
            most_effects: options.most_effects,
            strength: options.strength,
            ..Population::default()
        };
        let drawn = population.draw(&model.model, seed.child("effects"));
        let effects: Vec<_> = drawn.into_iter().map(|effect| effect.spec).collect();
        let robot = |noise_m: f64| {
            let mut spec = model.clone();
            spec.noise_m = noise_m;
            PlantSpec::Simulated(spec).with_effects(&effects).build(self.step_s)
        };
        let poses =
            tasks::reached_poses(robot(0.0)?.as_mut(), &self.explore, options.targets, seed);
        let poses = poses.map_err(|error| error.to_string())?;
        let trajectories =
            tasks::imitate(robot(options.noise_m)?.as_mut(), policy, &poses, options.ticks, seed);
        trajectories.map_err(|error| error.to_string())
    }
}
