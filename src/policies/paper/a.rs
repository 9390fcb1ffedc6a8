//! Policy A (Algorithm 2): the inverse mapping learnt in simulation, with the target moved into the
//! simulated workspace by the error model, x_s-target = x_real-target + e_gp(L, x_s-target) (eq.
//! 23).
//!
//! One iteration of the algorithm is one control tick. The algorithm reads the tracker between
//! asking the network and the next question; a tick reads it first, so the position of tick i is
//! x_real(i) + e_gp(i − 1), as printed.

use std::sync::Arc;

use crate::base::{BadOption, Displacements, Point3, PolicyError, distance_m};
use crate::policies::parts::network::RecurrentInverse;
use crate::policies::parts::single_controller::{ControlLaw, Demand, SingleController};
use crate::policies::parts::tip_tracker::TipReading;
use crate::policies::{
    Deserialize, ErrorModel, INVERSE, InverseModel, ModelNeed, NetworkOptions, PolicyEntry,
    PolicyOptions, Serialize, SeriesLabel,
};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "a",
    label: SeriesLabel::text("A"),
    needs: &[ModelNeed::Network(&INVERSE), ModelNeed::ErrorModel],
    make: |mut parts, options| {
        let model = parts.inverse("a", &INVERSE)?;
        let error = parts.error("a")?;
        Ok(Box::new(SingleController::new(AlgorithmTwo::new(model, error, options), "a", options)))
    },
    ..PolicyEntry::PLAIN
};

/// Choices that Algorithm 2 does not specify.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AOptions {
    /// The loop ends when x_s-target moves no further than this in one iteration; the paper's 0.001
    /// m.
    pub tolerance_m: f64,
    /// Iterations in one control tick, fewer when the criterion is met; 1 is Algorithm 2 as
    /// printed.
    pub iterations_per_tick: usize,
    /// Minimum number of iterations at a target before the criterion applies; 2 requires two
    /// evaluations of the network, as in the other policies.
    pub min_iterations: usize,
    /// The guess for a further target of the same run is moved by the last e_gp instead of being
    /// the target itself. At the first target there is no e_gp yet, and both are the printed guess.
    pub warm_start: bool,
    /// Keep the command at which the criterion was first met until the target changes, as the
    /// printed loop does when it ends, instead of iterating with feedback for as long as the task
    /// asks.
    pub hold_when_settled: bool,
}

impl Default for AOptions {
    fn default() -> Self {
        AOptions {
            tolerance_m: 0.001,
            iterations_per_tick: 1,
            min_iterations: 2,
            warm_start: true,
            hold_when_settled: false,
        }
    }
}

impl AOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_positive("tolerance_m", self.tolerance_m)?;
        BadOption::unless_counted("iterations_per_tick", self.iterations_per_tick)?;
        BadOption::unless_counted("min_iterations", self.min_iterations)
    }
}

/// Algorithm 2 with its state between ticks.
pub(crate) struct AlgorithmTwo {
    network: RecurrentInverse,
    error: Arc<dyn ErrorModel>,
    options: AOptions,
    network_options: NetworkOptions,
    /// x_real-target of the loop in progress.
    target_m: Option<Point3>,
    /// Iterations of that loop so far.
    iterations: usize,
    /// x_s-target(i).
    simulated_target_m: Point3,
    /// x_initial: the current position in the simulated workspace.
    position_m: Point3,
    /// e_gp(i); zero before the first iteration, so that the first position is the one that was
    /// measured.
    error_m: Point3,
    /// Where the network was last asked to take the tip, in the simulated workspace.
    aim_m: Point3,
    /// The command at which the criterion was met, for `hold_when_settled`.
    held_m: Option<Displacements>,
}

impl AlgorithmTwo {
    pub(crate) fn new(
        model: Box<dyn InverseModel>,
        error: Arc<dyn ErrorModel>,
        options: &PolicyOptions,
    ) -> Self {
        AlgorithmTwo {
            network: RecurrentInverse::new(model, options.network.memory),
            error,
            options: options.a,
            network_options: options.network,
            target_m: None,
            iterations: 0,
            simulated_target_m: [0.0; 3],
            position_m: [0.0; 3],
            error_m: [0.0; 3],
            aim_m: [0.0; 3],
            held_m: None,
        }
    }

    /// Where the network was last asked to take the tip, in the simulated workspace, metres.
    pub(crate) fn aim_m(&self) -> Point3 {
        self.aim_m
    }

    /// Moves the target without beginning the loop again.
    pub(crate) fn retarget(&mut self, target_m: &Point3) {
        self.target_m = Some(*target_m);
    }

    /// One iteration: L(i), e_gp(i), x_s-target(i).
    fn iterate(&mut self, fresh: bool, target_m: &Point3) -> Result<Demand, PolicyError> {
        let aim_m = self.network_options.aim_m(&self.position_m, &self.simulated_target_m, fresh);
        let pulls_m = self.network.pulls(&self.position_m, &aim_m)?;
        self.aim_m = aim_m;
        self.error_m = self.error.error_m(&pulls_m, &aim_m);
        PolicyError::unless_finite("error model", &self.error_m)?;
        let next_m = sum(target_m, &self.error_m);
        self.iterations += 1;
        let settled = self.iterations >= self.options.min_iterations
            && distance_m(&self.simulated_target_m, &next_m) <= self.options.tolerance_m;
        self.simulated_target_m = next_m;
        Ok(Demand { pulls_m, settled })
    }
}

impl ControlLaw for AlgorithmTwo {
    fn reset(&mut self) {
        self.network.reset();
        self.target_m = None;
        self.error_m = [0.0; 3];
        self.held_m = None;
    }

    fn decide(&mut self, reading: TipReading, target_m: &Point3) -> Result<Demand, PolicyError> {
        if self.target_m != Some(*target_m) {
            self.target_m = Some(*target_m);
            self.iterations = 0;
            self.simulated_target_m =
                if self.options.warm_start { sum(target_m, &self.error_m) } else { *target_m };
            self.held_m = None;
        }
        // Without a new measurement (open loop) "the initial position does not change".
        if reading.fresh {
            self.position_m = sum(&reading.tip_m, &self.error_m);
        }
        self.network.begin(reading.fresh);
        if self.options.hold_when_settled
            && let Some(held_m) = &self.held_m
        {
            return Ok(Demand { pulls_m: held_m.clone(), settled: true });
        }
        let mut demand = self.iterate(reading.fresh, target_m)?;
        for _ in 1..self.options.iterations_per_tick {
            if demand.settled {
                break;
            }
            demand = self.iterate(reading.fresh, target_m)?;
        }
        if demand.settled {
            self.held_m = Some(demand.pulls_m.clone());
        }
        Ok(demand)
    }
}

fn sum(a: &Point3, b: &Point3) -> Point3 {
    std::array::from_fn(|axis| a[axis] + b[axis])
}
