//! A policy that is an inverse network and nothing else, eq. (22): B and π_real differ in what the
//! network learnt from.

use serde::{Deserialize, Serialize};

use super::actuator_limits::largest_change_m;
use super::network::RecurrentInverse;
use super::single_controller::{ControlLaw, Demand};
use super::tip_tracker::TipReading;
use crate::base::{BadOption, Displacements, Point3, PolicyError};
use crate::policies::{InverseModel, NetworkOptions, PolicyOptions};

/// Settling of a network without feedback.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DirectOptions {
    /// Settled when no tendon's demanded displacement changed by more than this since the last
    /// tick.
    pub settle_pull_m: f64,
}

impl Default for DirectOptions {
    fn default() -> Self {
        // Moves the tip by about the 1 mm at which Algorithm 2 stops: 3–5 mm of tip for a
        // millimetre of tendon.
        DirectOptions { settle_pull_m: 0.0002 }
    }
}

impl DirectOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("settle_pull_m", self.settle_pull_m)
    }
}

/// The network with its last demand.
pub(crate) struct InverseNetworkController {
    network: RecurrentInverse,
    network_options: NetworkOptions,
    options: DirectOptions,
    last: Option<(Point3, Displacements)>,
}

impl InverseNetworkController {
    pub(crate) fn new(model: Box<dyn InverseModel>, options: &PolicyOptions) -> Self {
        InverseNetworkController {
            network: RecurrentInverse::new(model, options.network.memory),
            network_options: options.network,
            options: options.direct,
            last: None,
        }
    }
}

impl ControlLaw for InverseNetworkController {
    fn reset(&mut self) {
        self.network.reset();
        self.last = None;
    }

    /// (x_i, x_target) → u_i.
    fn decide(&mut self, reading: TipReading, target_m: &Point3) -> Result<Demand, PolicyError> {
        self.network.begin(reading.fresh);
        let aim_m = self.network_options.aim_m(&reading.tip_m, target_m, reading.fresh);
        let pulls_m = self.network.pulls(&reading.tip_m, &aim_m)?;
        let settled = self.last.as_ref().is_some_and(|(last_target_m, last_m)| {
            last_target_m == target_m
                && largest_change_m(last_m, &pulls_m) <= self.options.settle_pull_m
        });
        self.last = Some((*target_m, pulls_m.clone()));
        Ok(Demand { pulls_m, settled })
    }
}
