//! A policy that is an inverse network and nothing else, eq. (22): B and π_real differ in what the network learnt from.

use serde::{Deserialize, Serialize};

use super::limits::{Limits, largest_change_m};
use super::network::Network;
use super::sight::{Glance, Sight};
use super::{InverseModel, NetworkOptions, PolicyOptions};
use crate::base::{Action, BadOption, Displacements, Observation, Point3, Policy, PolicyError};

/// When a network alone has settled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DirectOptions {
    /// Settled when no tendon's wanted displacement changed by more than this since the last tick.
    pub settle_pull_m: f64,
}

impl Default for DirectOptions {
    fn default() -> Self {
        // Moves the tip by about the 1 mm at which Algorithm 2 stops: 3–5 mm of tip for a millimetre of tendon.
        DirectOptions { settle_pull_m: 0.0002 }
    }
}

impl DirectOptions {
    pub(super) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("settle_pull_m", self.settle_pull_m)
    }
}

/// What a controller wants before the drive's limits.
pub(super) struct Wanted {
    pub(super) pulls_m: Displacements,
    pub(super) settled: bool,
}

/// The network with what it wanted last.
pub(super) struct Direct {
    network: Network,
    network_options: NetworkOptions,
    options: DirectOptions,
    last: Option<(Point3, Displacements)>,
}

impl Direct {
    pub(super) fn new(model: Box<dyn InverseModel>, options: &PolicyOptions) -> Self {
        Direct {
            network: Network::new(model, options.network.memory),
            network_options: options.network,
            options: options.direct,
            last: None,
        }
    }

    pub(super) fn reset(&mut self) {
        self.network.reset();
        self.last = None;
    }

    /// One control tick: (x_i, x_target) → u_i.
    pub(super) fn decide(&mut self, glance: Glance, target_m: &Point3) -> Result<Wanted, PolicyError> {
        self.network.begin(glance.fresh);
        let aim_m = self.network_options.aim_m(&glance.tip_m, target_m, glance.fresh);
        let pulls_m = self.network.pulls(&glance.tip_m, &aim_m)?;
        let settled = self.last.as_ref().is_some_and(|(last_target_m, last_m)| {
            last_target_m == target_m && largest_change_m(last_m, &pulls_m) <= self.options.settle_pull_m
        });
        self.last = Some((*target_m, pulls_m.clone()));
        Ok(Wanted { pulls_m, settled })
    }
}

/// [`Direct`] behind the drive's limits.
pub(super) struct DirectPolicy {
    core: Direct,
    sight: Sight,
    limits: Limits,
    branch: &'static str,
}

impl DirectPolicy {
    pub(super) fn new(model: Box<dyn InverseModel>, branch: &'static str, options: &PolicyOptions) -> Self {
        DirectPolicy {
            core: Direct::new(model, options),
            sight: Sight::default(),
            limits: Limits::new(options.limits),
            branch,
        }
    }
}

impl Policy for DirectPolicy {
    fn reset(&mut self) {
        self.core.reset();
        self.sight.reset();
        self.limits.reset();
    }

    fn act(&mut self, seen: &Observation, target_m: &Point3) -> Result<Action, PolicyError> {
        let glance = self.sight.look(seen, target_m)?;
        let wanted = self.core.decide(glance, target_m)?;
        let limited = self.limits.apply(&wanted.pulls_m, &seen.pulls_m)?;
        Ok(Action { pulls_m: limited.pulls_m, settled: wanted.settled && limited.arrived, branch: self.branch })
    }
}
