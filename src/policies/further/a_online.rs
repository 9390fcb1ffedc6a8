//! Policy A whose error model goes on learning: each command that the drive has carried out and the
//! tip that was measured under it are a further point of the Gaussian process (eq. 20), until the
//! trial ends.

use std::sync::Arc;

use crate::base::{BadOption, Displacements, Point3, PolicyError, distance_m};
use crate::learn::gp::Leaving;
use crate::policies::paper::a::AlgorithmTwo;
use crate::policies::parts::actuator_limits::ActuatorLimits;
use crate::policies::parts::single_controller::{ControlLaw, Demand, SingleController};
use crate::policies::parts::tip_tracker::TipReading;
use crate::policies::{
    BuildError, Deserialize, ErrorModel, INVERSE, LearningErrorModel, ModelNeed, PolicyEntry,
    Serialize, SeriesLabel,
};

pub(crate) const ENTRY: PolicyEntry = PolicyEntry {
    name: "a_online",
    label: SeriesLabel::text("A, learning on"),
    footnote: "A whose Gaussian process takes each measured point of the trial.",
    needs: &[ModelNeed::Network(&INVERSE), ModelNeed::ErrorModel],
    make: |mut parts, options| {
        let model = parts.inverse("a_online", &INVERSE)?;
        let AOnlineOptions { points, leaves, most_m } = options.a_online;
        let missing =
            BuildError::Missing { policy: "a_online", model: "error model that learns on" };
        let fitted = parts.error("a_online")?;
        let learning = fitted.learning(points, leaves).ok_or(missing)?;
        let bounded = Arc::new(BoundedError { learning: Arc::clone(&learning), fitted, most_m });
        let controller = LearningA {
            a: AlgorithmTwo::new(model, bounded, options),
            error: learning,
            limits: ActuatorLimits::new(options.limits),
            carried_out: None,
        };
        Ok(Box::new(SingleController::new(controller, "", options)))
    },
    ..PolicyEntry::PLAIN
};

/// Options of A with online learning.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AOnlineOptions {
    /// Largest number of points that a trial adds, 1 to 1000; beyond it, each new point replaces an
    /// added one. Fitted points stay.
    pub points: usize,
    /// Rule for the replaced point.
    pub leaves: Leaving,
    /// Largest shift of the target by points learned in the trial, metres: outside the workspace
    /// the tip does not follow, and the remaining error would be learned repeatedly as a gap.
    pub most_m: f64,
}

impl Default for AOnlineOptions {
    fn default() -> Self {
        AOnlineOptions { points: 100, leaves: Leaving::Oldest, most_m: 0.03 }
    }
}

impl AOnlineOptions {
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_within("points", self.points, 1..=1000, "a whole number from 1 to 1000")?;
        BadOption::unless_positive("most_m", self.most_m)
    }
}

/// The error model that learns on, within a distance of the one that was fitted.
struct BoundedError {
    learning: Arc<dyn LearningErrorModel>,
    fitted: Arc<dyn ErrorModel>,
    most_m: f64,
}

impl ErrorModel for BoundedError {
    fn error_m(&self, pulls_m: &[f64], p_sim_m: &Point3) -> Point3 {
        let learned_m = self.learning.error_m(pulls_m, p_sim_m);
        let fitted_m = self.fitted.error_m(pulls_m, p_sim_m);
        let moved_m = distance_m(&learned_m, &fitted_m);
        if moved_m <= self.most_m {
            return learned_m;
        }
        let share = self.most_m / moved_m;
        std::array::from_fn(|axis| fitted_m[axis] + share * (learned_m[axis] - fitted_m[axis]))
    }
}

struct LearningA {
    a: AlgorithmTwo,
    /// What `a` asks, within its bound.
    error: Arc<dyn LearningErrorModel>,
    /// A copy of the drive's limits, to know when the command in force is the one that was
    /// demanded.
    limits: ActuatorLimits,
    /// That command and the simulated tip that the network was asked for with it; nothing while the
    /// drive is on its way.
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
        Arc::new(
            GpError::new(Gp::fit(&inputs, &outputs, &GpConfig::default()).unwrap(), 2).unwrap(),
        )
    }

    /// Distance from target to true tip after so many ticks with a gap that has grown by 5 mm.
    fn remaining_m(a: &mut dyn ControlLaw, ticks: usize) -> f64 {
        let target_m = [0.03, -0.01, 0.2];
        let mut tip_m = [0.0, 0.0, 0.2];
        for _ in 0..ticks {
            let pulls_m = a
                .decide(TipReading { tip_m, time_s: 0.0, fresh: true }, &target_m)
                .unwrap()
                .pulls_m;
            let x_m = 4.0 * pulls_m[0];
            tip_m = [x_m - gap_m(x_m) - 0.005, 4.0 * pulls_m[1], 0.2];
        }
        crate::base::distance_m(&tip_m, &target_m)
    }

    fn online(learning: &Arc<dyn LearningErrorModel>, max_step_m: Option<f64>) -> LearningA {
        let mut options = PolicyOptions::default();
        options.limits.max_step_m = max_step_m;
        let a = AlgorithmTwo::new(
            Box::new(Linear),
            Arc::<dyn LearningErrorModel>::clone(learning),
            &options,
        );
        LearningA {
            a,
            error: learning.clone(),
            limits: ActuatorLimits::new(options.limits),
            carried_out: None,
        }
    }

    #[test]
    fn what_the_process_was_not_told_is_learned_in_the_trial_and_forgotten_after_it() {
        let error = error_model();
        let mut plain =
            AlgorithmTwo::new(Box::new(Linear), error.clone(), &PolicyOptions::default());
        let learning = error.learning(100, Leaving::Oldest).unwrap();
        let mut online = online(&learning, None);
        let (without, with) = (remaining_m(&mut plain, 60), remaining_m(&mut online, 60));
        assert!(without > 0.004 && with < 0.5 * without, "{without} {with}");
        let predicted_m =
            |model: &dyn ErrorModel| model.error_m(&[0.009, -0.002], &[0.036, -0.01, 0.2]);
        assert_ne!(predicted_m(&*learning), predicted_m(&*error));
        online.reset();
        assert_eq!(predicted_m(&*learning), predicted_m(&*error));
    }

    /// A tip that does not follow: what is learned says ever more, and the target moves no further
    /// than the bound.
    #[test]
    fn what_is_learned_moves_the_target_no_further_than_the_bound() {
        let error = error_model();
        let learning = error.learning(100, Leaving::Oldest).unwrap();
        let bounded =
            BoundedError { learning: learning.clone(), fitted: error.clone(), most_m: 0.004 };
        let (pulls_m, simulated_m) = ([0.009, -0.002], [0.036, -0.01, 0.2]);
        assert_eq!(bounded.error_m(&pulls_m, &simulated_m), error.error_m(&pulls_m, &simulated_m));
        for _ in 0..20 {
            learning.measured(&pulls_m, &simulated_m, &[0.0, -0.01, 0.2]).unwrap();
        }
        let moved_m = |model: &dyn ErrorModel| {
            let asked_m = model.error_m(&pulls_m, &simulated_m);
            distance_m(&asked_m, &error.error_m(&pulls_m, &simulated_m))
        };
        assert!(moved_m(&*learning) > 0.01, "{}", moved_m(&*learning));
        assert!((moved_m(&bounded) - 0.004).abs() < 1e-12, "{}", moved_m(&bounded));
    }

    #[test]
    fn nothing_is_learned_in_open_loop_or_while_the_drive_is_on_its_way() {
        let error = error_model();
        let learning = error.learning(100, Leaving::MostAlike).unwrap();
        let mut online = online(&learning, Some(0.0001));
        remaining_m(&mut online, 5);
        let predicted_m =
            |model: &dyn ErrorModel| model.error_m(&[0.009, -0.002], &[0.036, -0.01, 0.2]);
        assert_eq!(predicted_m(&*learning), predicted_m(&*error));
    }
}
