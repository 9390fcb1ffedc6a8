//! A robot at work: one trial after another from rest at home towards a target that is drawn, each
//! of the same number of steps. The model plays the same commands beside it.

use rand::RngExt;

use super::watched::{WatchedRobot, WatchedStep};
use crate::base::{Point3, Policy, Seed};
use crate::policies::ErrorModel;

/// A robot with its model beside it, the policy that commands both, and the targets that it works
/// on.
pub struct Work<'a> {
    /// The robot; in place of the robot without noise stands the model.
    pub robot: WatchedRobot,
    /// The policy.
    pub policy: Box<dyn Policy>,
    /// The gap between model and robot that is known.
    pub error: Box<dyn ErrorModel>,
    /// Targets to draw from, metres; at least one.
    pub pool_m: &'a [Point3],
    /// Number of steps of a trial.
    pub steps: usize,
    /// Seed of targets and noise.
    pub seed: Seed,
}

impl Work<'_> {
    /// The innovation of each step of trial number `index`, metres: the measured tip less what
    /// model and error model foretell, `p_sim − e` (eq. 20). A step without a measurement has none;
    /// a trial that fails on the way ends there.
    pub fn innovations_m(&mut self, index: u64) -> Vec<Option<Point3>> {
        let seed = self.seed.index(index);
        let target_m = self.pool_m[seed.child("target").rng().random_range(0..self.pool_m.len())];
        // Trials of one length: a calibration may draw any of them.
        let targets = std::iter::repeat_n(target_m, self.steps);
        let run = self.robot.run(self.policy.as_mut(), targets, false, seed.child("plant"));
        run.steps.iter().map(|step| innovation_m(step, self.error.as_ref())).collect()
    }
}

fn innovation_m(step: &WatchedStep, error: &dyn ErrorModel) -> Option<Point3> {
    // In place of the true tip stands that of the model.
    let simulated_m = &step.true_m;
    let error_m = error.error_m(&step.pulls_m, simulated_m);
    let innovation_m: Point3 =
        std::array::from_fn(|axis| step.measured_m[axis] - simulated_m[axis] + error_m[axis]);
    innovation_m.iter().all(|value| value.is_finite()).then_some(innovation_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Gap;
    impl ErrorModel for Gap {
        fn error_m(&self, pulls_m: &[f64], _: &Point3) -> Point3 {
            [0.001 + pulls_m[0], 0.0, 0.0]
        }
    }

    #[test]
    fn what_the_error_model_knows_is_no_innovation() {
        let step = |measured_m: Point3| WatchedStep {
            time_s: 0.2,
            measured_m,
            true_m: [0.021, 0.0, 0.19],
            target_m: [0.0; 3],
            pulls_m: vec![0.01, -0.01],
        };
        let innovation = innovation_m(&step([0.010, 0.0, 0.19]), &Gap).unwrap();
        assert!(innovation.iter().all(|value| value.abs() < 1e-12), "{innovation:?}");
        assert_eq!(innovation_m(&step([f64::NAN; 3]), &Gap), None, "a lost pose is none");
    }
}
