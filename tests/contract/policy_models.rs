//! Controllers that ask the model: on robots of several segments, and where the model has no plan.

use crate::support::policies::{ConstantError, policy, seen};
use spinebench::base::{
    NoRestPose, Outcome, Plant, Point3, PolicyError, RestPose, Seed, TendonLayout, TipModel,
};
use spinebench::effects::{EffectSpec, Model};
use spinebench::plants::{PlantSpec, Simulated, SimulatedOptions, SimulatedSpec};
use spinebench::policies::{LimitOptions, PolicyOptions, PolicyParts};
use spinebench::specs::{read_model, suited_travel_m};
use spinebench::tasks::{
    GridOptions, LoopMode, ReachOptions, TargetOptions, reach, target_pool, tip_model,
};
use std::path::Path;
use std::sync::Arc;

fn model(file: &str) -> Model {
    read_model(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(file)).unwrap()
}

fn spec(model: &Model) -> PlantSpec {
    PlantSpec::Simulated(Box::new(SimulatedSpec {
        model: model.clone(),
        noise_m: 0.0,
        travel_m: 0.06,
    }))
}

/// Errors of `policy` at targets that the model reaches with two thirds of the travel, metres.
fn errors_m(name: &str, file: &str, hidden: &[EffectSpec], noise_m: f64) -> Vec<f64> {
    let model = model(file);
    let travel_m = suited_travel_m(spec(&model).size());
    let step_m = 0.15 * travel_m;
    let max_pull_m = travel_m / 1.5;
    let sweep = GridOptions { rows: 3, columns: 3, max_pull_m, max_step_m: step_m };
    let targets = TargetOptions { pool: 4, drawn: 4, sweep };
    let robot_of = |effects: &[EffectSpec], noise_m: f64| {
        Simulated::new(&model, effects, SimulatedOptions { noise_m, ..SimulatedOptions::default() })
    };
    let pool = target_pool(&mut robot_of(&[], 0.0), &targets, Seed(1)).unwrap();
    let limits = LimitOptions { travel_m, max_step_m: Some(step_m) };
    let options = PolicyOptions { limits, ..PolicyOptions::default() };
    let parts = PolicyParts::default()
        .with_error(Arc::new(ConstantError([0.0; 3])))
        .with_layout(spec(&model).tendon_layout())
        .with_tip_model(tip_model(&spec(&model)).unwrap());
    let mut controller = policy(name, parts, &options);
    let mut robot = robot_of(hidden, noise_m);
    let trial = ReachOptions { max_steps: 40, averaged_samples: 5, ..ReachOptions::default() };
    let mut error_m = |target_m: &Point3| {
        let mode = LoopMode::Closed;
        let seed = Seed(2);
        let outcome = reach(&mut robot, controller.as_mut(), target_m, mode, &trial, seed).unwrap();
        assert_eq!(outcome.status, Outcome::Ok, "{file}");
        outcome.error_m
    };
    pool.iter().map(&mut error_m).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn a_perfect_model_of_several_segments_reaches_its_targets() {
    for file in ["real/v4.yaml", "real/v6.yaml", "real/trunk.yaml", "trunk.yaml"] {
        for name in ["model_integral", "mpc"] {
            let errors_m = errors_m(name, file, &[], 0.0);
            assert!(mean(&errors_m) < 0.0005, "{file} {name}: {errors_m:?}");
        }
    }
}

#[test]
fn a_hidden_gain_and_noise_leave_little_more_than_the_noise() {
    let gain: EffectSpec =
        serde_json::from_str(r#"{"actuator_gain": {"tendon": 1, "scale": 1.05}}"#).unwrap();
    // The mean distance of a tip with this noise on each axis from its true place is 0.8 mm.
    for file in ["real/v4.yaml", "real/v6.yaml", "real/trunk.yaml"] {
        let errors_m = errors_m("model_integral", file, std::slice::from_ref(&gain), 0.0005);
        assert!(mean(&errors_m) < 1.5 * 0.0008, "{file}: {errors_m:?}");
    }
}

#[test]
fn a_robot_that_swings_otherwise_than_its_model_is_not_excited() {
    let softer: EffectSpec =
        serde_json::from_str(r#"{"bending_stiffness": {"scale": 0.8}}"#).unwrap();
    let errors_m = errors_m("model_integral", "real/v6.yaml", std::slice::from_ref(&softer), 0.0);
    assert!(mean(&errors_m) < 0.001, "{errors_m:?}");
}

/// A model that comes to rest where its bend is no larger than `max_bend_m`.
struct Fragile {
    max_bend_m: f64,
    gain: f64,
}

impl TipModel for Fragile {
    fn bends(&self) -> usize {
        2
    }

    fn lever_m(&self) -> f64 {
        0.02
    }

    fn at_rest(&mut self, bend_m: &[f64]) -> Result<RestPose, NoRestPose> {
        if bend_m.iter().any(|bend_m| bend_m.abs() > self.max_bend_m) {
            return Err(NoRestPose("buckles".to_owned()));
        }
        let [a, b] = [bend_m[0], bend_m[1]];
        let pulls_m = [a, b, -a, -b].map(|pull_m| self.gain * pull_m).to_vec();
        Ok(RestPose { pulls_m, tip_m: [4.0 * a, 4.0 * b, 0.2] })
    }

    fn tip_per_bend(&mut self, bend_m: &[f64]) -> Result<Vec<Point3>, NoRestPose> {
        self.at_rest(bend_m)?;
        Ok(vec![[4.0, 0.0, 0.0], [0.0, 4.0, 0.0]])
    }
}

#[test]
fn a_model_without_a_plan_is_a_named_failure() {
    let decided = |fragile: Fragile| {
        let parts = PolicyParts::default()
            .with_layout(TendonLayout::ring(4))
            .with_tip_model(Box::new(fragile));
        let mut controller = policy("model_integral", parts, &PolicyOptions::default());
        controller.act(&seen(0, [0.0, 0.0, 0.2]), &[0.05, 0.0, 0.2])
    };
    assert!(decided(Fragile { max_bend_m: 1.0, gain: 1.0 }).is_ok());
    for (fragile, why) in [
        (Fragile { max_bend_m: -1.0, gain: 1.0 }, "at home"),
        (Fragile { max_bend_m: 1e-9, gain: 1.0 }, "no equilibrium on the path"),
        (Fragile { max_bend_m: 1.0, gain: f64::NAN }, "at home"),
    ] {
        let failure = decided(fragile).unwrap_err();
        assert!(matches!(failure, PolicyError::PlanFailed(_)), "{failure}");
        let words = failure.to_string();
        assert!(words.starts_with("plan_failed: ") && words.contains(why), "{words}");
    }
}

#[test]
fn a_trial_without_a_plan_says_so_in_its_row() {
    let parts = PolicyParts::default()
        .with_layout(TendonLayout::ring(4))
        .with_tip_model(Box::new(Fragile { max_bend_m: -1.0, gain: 1.0 }));
    let mut controller = policy("model_integral", parts, &PolicyOptions::default());
    let mut robot = spec(&Model::default()).build(0.2).unwrap();
    let target_m = [0.05, 0.0, 0.2];
    let trial = ReachOptions::default();
    let robot: &mut dyn Plant = robot.as_mut();
    let outcome =
        reach(robot, controller.as_mut(), &target_m, LoopMode::Closed, &trial, Seed(1)).unwrap();
    assert_eq!(
        outcome.status.as_str(),
        "policy: plan_failed: the model has no equilibrium at home"
    );
}
