//! Policy A whose error model goes on learning: each command that the drive has carried out and the tip that was measured under it
//! are a further point of the Gaussian process (eq. 20), until the trial ends.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::a::AlgorithmTwo;
use super::actuator_limits::ActuatorLimits;
use super::single_controller::{ControlLaw, Demand, SingleController};
use super::tip_tracker::TipReading;
use super::{BuildError, INVERSE, LearningErrorModel, ModelAccess, ModelNeed, PolicyEntry};
use crate::base::series::SeriesLabel;
use crate::base::{BadOption, Displacements, Point3, PolicyError};
use crate::learn::gp::Leaving;

pub(super) const ENTRY: PolicyEntry = PolicyEntry {
    name: "a_online",
    label: SeriesLabel::text("A, learning on"),
    look: None,
    footnote: "A whose Gaussian process takes each measured point of the trial.",
    needs: &[ModelNeed::Network(&INVERSE), ModelNeed::ErrorModel],
    model: ModelAccess::None,
    closed_loop_only: false,
    make: |mut parts, options| {
        let model = parts.inverse("a_online", &INVERSE)?;
        let AOnlineOptions { points, leaves } = options.a_online;
        let missing = BuildError::Missing { policy: "a_online", model: "error model that learns on" };
        let error = parts.error("a_online")?.learning(points, leaves).ok_or(missing)?;
        let controller = LearningA {
            a: AlgorithmTwo::new(model, Arc::<dyn LearningErrorModel>::clone(&error), options),
            error,
            limits: ActuatorLimits::new(options.limits),
            carried_out: None,
        };
        Ok(Box::new(SingleController::new(controller, "", options)))
    },
};

/// Options of A that learns on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AOnlineOptions {
    /// Most points that a trial adds, 1 to 1000; then one leaves for each that comes. Those that were fitted stay.
    pub points: usize,
    /// Which of them leaves.
    pub leaves: Leaving,
}

impl Default for AOnlineOptions {
    fn default() -> Self {
        AOnlineOptions { points: 100, leaves: Leaving::Oldest }
    }
}

impl AOnlineOptions {
    pub(super) fn check(&self) -> Result<(), BadOption> {
        super::option_ranges::unless_count_to("points", self.points, 1000, "a whole number from 1 to 1000")
    }
}

struct LearningA {
    a: AlgorithmTwo,
    /// The error model of `a`.
    error: Arc<dyn LearningErrorModel>,
    /// A copy of the drive's limits, to know when the command in force is the one that was demanded.
    limits: ActuatorLimits,
    /// That command and the simulated tip that the network was asked for with it; nothing while the drive is on its way.
    carried_out: Option<(Displacements, Point3)>,
}

impl ControlLaw for LearningA {
    fn reset(&mut self) {
        self.a.reset();
        self.error.restart();
        self.limits.reset();
        self.carried_out = None;
    }

    fn decide(&mut self, reading: TipReading, target_m: &Point3) -> Result<Demand, PolicyError> {
        if let Some((pulls_m, simulated_m)) = self.carried_out.take().filter(|_| reading.fresh) {
            self.error.measured(&pulls_m, &simulated_m, &reading.tip_m)?;
        }
        let demand = self.a.decide(reading, target_m)?;
        let arrived = self.limits.apply(&demand.pulls_m, &vec![0.0; demand.pulls_m.len()])?.arrived;
        self.carried_out = arrived.then(|| (demand.pulls_m.clone(), self.a.aim_m()));
        Ok(demand)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rows;
    use crate::learn::gp::{Gp, GpConfig};
    use crate::policies::{ErrorModel, GpError, InverseModel, PolicyOptions};

    /// A robot whose tip stands at 4 m for each metre of pull, and a network that believes it.
    struct Linear;

    impl InverseModel for Linear {
        fn reset(&mut self) {}

        fn pulls(&mut self, _from_m: &Point3, to_m: &Point3) -> Result<Displacements, PolicyError> {
            Ok(vec![0.25 * to_m[0], 0.25 * to_m[1]])
        }
    }

    /// The gap along x.
    fn gap_m(x_m: f64) -> f64 {
        0.003 + 0.003 * (25.0 * x_m).sin()
    }

    /// Fitted to that gap and a smaller one along y.
    fn error_model() -> Arc<dyn ErrorModel> {
        let (mut inputs, mut outputs) = (Rows::new(5), Rows::new(3));
        for i in (0..40).map(f64::from) {
            let (x, y) = (0.05 * (1.7 * i).sin(), 0.05 * (0.9 * i).cos());
            inputs.push(&[0.25 * x, 0.25 * y, x, y, 0.2]);
            let noise = |k: f64| 0.0004 * (k * i).sin();
            outputs.push(&[gap_m(x) + noise(7.1), 0.05 * x + noise(3.3), noise(5.7)]);
        }
        Arc::new(GpError::new(Gp::fit(&inputs, &outputs, &GpConfig::default()).unwrap(), 2).unwrap())
    }

    /// Distance from target to true tip after so many ticks with a gap that has grown by 5 mm.
    fn remaining_m(a: &mut dyn ControlLaw, ticks: usize) -> f64 {
        let target_m = [0.03, -0.01, 0.2];
        let mut tip_m = [0.0, 0.0, 0.2];
        for _ in 0..ticks {
            let pulls_m = a.decide(TipReading { tip_m, fresh: true }, &target_m).unwrap().pulls_m;
            let x_m = 4.0 * pulls_m[0];
            tip_m = [x_m - gap_m(x_m) - 0.005, 4.0 * pulls_m[1], 0.2];
        }
        crate::base::distance_m(&tip_m, &target_m)
    }

    #[test]
    fn what_the_process_was_not_told_is_learned_in_the_trial_and_forgotten_after_it() {
        let mut options = PolicyOptions::default();
        options.limits.max_step_m = None;
        let error = error_model();
        let mut plain = AlgorithmTwo::new(Box::new(Linear), error.clone(), &options);
        let learning = error.learning(100, Leaving::Oldest).unwrap();
        let a = AlgorithmTwo::new(Box::new(Linear), Arc::<dyn LearningErrorModel>::clone(&learning), &options);
        let limits = ActuatorLimits::new(options.limits);
        let mut online = LearningA { a, error: learning.clone(), limits, carried_out: None };
        let (without, with) = (remaining_m(&mut plain, 60), remaining_m(&mut online, 60));
        assert!(without > 0.004 && with < 0.5 * without, "{without} {with}");
        let asked = |model: &dyn ErrorModel| model.error_m(&[0.009, -0.002], &[0.036, -0.01, 0.2]);
        assert_ne!(asked(&*learning), asked(&*error));
        online.reset();
        assert_eq!(asked(&*learning), asked(&*error));
    }

    #[test]
    fn nothing_is_learned_in_open_loop_or_while_the_drive_is_on_its_way() {
        let mut options = PolicyOptions::default();
        options.limits.max_step_m = Some(0.0001);
        let error = error_model();
        let learning = error.learning(100, Leaving::MostAlike).unwrap();
        let a = AlgorithmTwo::new(Box::new(Linear), Arc::<dyn LearningErrorModel>::clone(&learning), &options);
        let limits = ActuatorLimits::new(options.limits);
        let mut online = LearningA { a, error: learning.clone(), limits, carried_out: None };
        remaining_m(&mut online, 5);
        let asked = |model: &dyn ErrorModel| model.error_m(&[0.009, -0.002], &[0.036, -0.01, 0.2]);
        assert_eq!(asked(&*learning), asked(&*error));
    }
}
