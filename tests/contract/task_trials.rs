//! Goal reaching and path tracking: what is shown, when they end, what they report.

use crate::support::policies::{exact_parts, policy, reachable, robot};
use spinebench::base::{
    Action, Observation, Plant, PlantError, Point3, Policy, PolicyError, Seed, TendonCommand,
};
use spinebench::plants::{ConstantCurvature, ConstantCurvatureOptions};
use spinebench::policies::{PolicyOptions, REGISTRY};
use spinebench::tasks::{
    LoopMode, PathOptions, ReachOptions, TrackOptions, interpolate, reach, track, waypoints,
};

const SHIFT_M: Point3 = [-0.012, 0.004, 0.0];

/// A policy that writes down what it is shown and answers with a constant.
#[derive(Default)]
struct Witness {
    seen: Vec<Observation>,
    settles_at: Option<usize>,
    fails_at: Option<usize>,
}

impl Policy for Witness {
    fn reset(&mut self) {
        self.seen.clear();
    }

    fn act(&mut self, seen: &Observation, _target_m: &Point3) -> Result<Action, PolicyError> {
        self.seen.push(seen.clone());
        if self.fails_at == Some(self.seen.len()) {
            return Err(PolicyError::NotFinite("witness"));
        }
        let settled = self.settles_at.is_some_and(|step| self.seen.len() >= step);
        let branch = if self.seen.len() % 4 < 2 { "a" } else { "b" };
        Ok(Action { pulls_m: vec![0.01, 0.0, -0.01, 0.0], settled, branch })
    }
}

/// A plant that breaks at a step.
struct Breaks(ConstantCurvature, usize);

impl Plant for Breaks {
    fn tendons(&self) -> usize {
        self.0.tendons()
    }
    fn step_s(&self) -> f64 {
        self.0.step_s()
    }
    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError> {
        self.0.reset(seed)
    }
    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        self.1 -= 1;
        if self.1 == 0 { Err(PlantError::Solver("broke".into())) } else { self.0.drive(commands) }
    }
}

#[test]
fn open_loop_is_shown_home_and_closed_loop_the_newest() {
    let mut witness = Witness::default();
    let options = ReachOptions { max_steps: 5, ..ReachOptions::default() };
    let outcome = reach(
        &mut robot(SHIFT_M),
        &mut witness,
        &[0.0, 0.0, 0.2],
        LoopMode::Open,
        &options,
        Seed(1),
    )
    .unwrap();
    assert_eq!(outcome.steps, 5);
    assert!(!outcome.settled);
    assert!(
        witness.seen.iter().all(|seen| *seen == witness.seen[0]) && witness.seen[0].time_s == 0.0
    );
    reach(&mut robot(SHIFT_M), &mut witness, &[0.0, 0.0, 0.2], LoopMode::Closed, &options, Seed(1))
        .unwrap();
    for (step, seen) in witness.seen.iter().enumerate() {
        assert!((seen.time_s - 0.2 * step as f64).abs() < 1e-12);
    }
    assert!(witness.seen[4].tip_m[0] > witness.seen[0].tip_m[0]);
}

#[test]
fn a_trial_ends_when_policy_and_tip_are_calm_for_long_enough() {
    let mut witness = Witness { settles_at: Some(12), ..Witness::default() };
    let options = ReachOptions { settle_steps: 4, hold_steps: 7, ..ReachOptions::default() };
    let outcome = reach(
        &mut robot(SHIFT_M),
        &mut witness,
        &[0.0, 0.0, 0.2],
        LoopMode::Closed,
        &options,
        Seed(1),
    )
    .unwrap();
    assert!(outcome.settled);
    assert_eq!(outcome.steps, 15 + 7);
    assert_eq!(witness.seen.len(), 15);
    let expected = witness.seen.len().div_ceil(2) - 1;
    assert!(outcome.switches == expected || outcome.switches == expected + 1, "a b b a a b b …");
}

#[test]
fn a_moving_tip_keeps_a_trial_open() {
    let slow = ConstantCurvatureOptions { lag_s: 2.0, ..ConstantCurvatureOptions::default() };
    let mut witness = Witness { settles_at: Some(1), ..Witness::default() };
    let mut steps = |rest_m| {
        let mut plant = ConstantCurvature::new(slow).unwrap();
        let options = ReachOptions { settle_steps: 1, rest_m, ..ReachOptions::default() };
        reach(&mut plant, &mut witness, &[0.0, 0.0, 0.2], LoopMode::Closed, &options, Seed(1))
            .unwrap()
            .steps
    };
    assert_eq!(steps(None), 1);
    assert!(steps(Some(0.001)) > steps(Some(0.002)) && steps(Some(0.002)) > 1);
}

#[test]
fn the_error_is_averaged_over_what_is_asked_for() {
    let noisy = ConstantCurvatureOptions { noise_m: 0.0005, ..ConstantCurvatureOptions::default() };
    let target_m = reachable(0.01, 0.0, [0.0; 3]);
    let spread = |averaged_samples| {
        let errors_m: Vec<f64> = (0..40)
            .map(|trial| {
                let mut plant = ConstantCurvature::new(noisy).unwrap();
                let options = ReachOptions {
                    max_steps: 40,
                    averaged_samples,
                    rest_m: None,
                    ..ReachOptions::default()
                };
                let mut witness = Witness::default();
                let seed = Seed(3).index(trial);
                let outcome =
                    reach(&mut plant, &mut witness, &target_m, LoopMode::Closed, &options, seed)
                        .unwrap();
                outcome.error_m
            })
            .collect();
        let mean_m = errors_m.iter().sum::<f64>() / 40.0;
        errors_m.iter().map(|error_m| (error_m - mean_m).powi(2)).sum::<f64>().sqrt()
    };
    assert!(spread(25) < 0.5 * spread(1));
}

#[test]
fn failures_are_a_status() {
    let target_m = [0.0, 0.0, 0.2];
    let options = ReachOptions::default();
    let mut broken = Breaks(robot(SHIFT_M), 4);
    let outcome =
        reach(&mut broken, &mut Witness::default(), &target_m, LoopMode::Closed, &options, Seed(1))
            .unwrap();
    assert_eq!(
        (outcome.status.as_str(), outcome.steps, outcome.settled),
        ("plant: rod solver: broke", 3, false)
    );
    assert!(outcome.error_m.is_finite());
    let mut failing = Witness { fails_at: Some(3), ..Witness::default() };
    let outcome =
        reach(&mut robot(SHIFT_M), &mut failing, &target_m, LoopMode::Closed, &options, Seed(1))
            .unwrap();
    assert_eq!((outcome.status.as_str(), outcome.steps), ("policy: not finite: witness", 2));
    let mut broken = Breaks(robot(SHIFT_M), 4);
    let steps = track(
        &mut broken,
        &mut Witness::default(),
        &[target_m; 3],
        &TrackOptions::default(),
        Seed(1),
    )
    .unwrap();
    assert_eq!(steps.len(), 4);
    assert!(steps[..3].iter().all(|step| step.status.is_ok()));
    assert_eq!(steps[3].status.as_str(), "plant: rod solver: broke");
}

#[test]
fn the_same_seed_gives_the_same_trial_for_every_policy() {
    let noisy = ConstantCurvatureOptions {
        noise_m: 0.0005,
        shift_m: SHIFT_M,
        ..ConstantCurvatureOptions::default()
    };
    let target_m = reachable(0.01, 0.01, SHIFT_M);
    for entry in REGISTRY {
        let run = |seed| {
            let mut plant = ConstantCurvature::new(noisy).unwrap();
            let mut policy = policy(entry.name, exact_parts(SHIFT_M), &PolicyOptions::default());
            let options = ReachOptions::default();
            reach(&mut plant, policy.as_mut(), &target_m, LoopMode::Closed, &options, seed).unwrap()
        };
        assert_eq!(run(Seed(1)), run(Seed(1)), "{}", entry.name);
        assert_ne!(run(Seed(1)).tip_m, run(Seed(2)).tip_m, "{}", entry.name);
        let exact = !entry.needs.is_empty();
        assert!(
            !exact || run(Seed(1)).error_m < 0.003,
            "{}: exact models reach the target",
            entry.name
        );
    }
}

#[test]
fn a_policy_that_was_used_before_gives_the_same_trial() {
    for entry in REGISTRY {
        let mut policy = policy(entry.name, exact_parts(SHIFT_M), &PolicyOptions::default());
        let mut plant = robot(SHIFT_M);
        let mut run = |x_m: f64| {
            let target_m = reachable(x_m, 0.01, SHIFT_M);
            let options = ReachOptions::default();
            reach(&mut plant, policy.as_mut(), &target_m, LoopMode::Closed, &options, Seed(1))
                .unwrap()
        };
        let first = run(0.012);
        run(-0.02);
        assert_eq!(run(0.012), first, "{}", entry.name);
    }
}

#[test]
fn exact_models_track_the_whole_path() {
    let options = PathOptions::default();
    let path =
        interpolate(&waypoints(&mut robot(SHIFT_M), &options, Seed(1)).unwrap(), &options).unwrap();
    for entry in REGISTRY.iter().filter(|entry| !entry.needs.is_empty()) {
        let mut policy = policy(entry.name, exact_parts(SHIFT_M), &PolicyOptions::default());
        let steps =
            track(&mut robot(SHIFT_M), policy.as_mut(), &path, &TrackOptions::default(), Seed(1))
                .unwrap();
        assert!(steps.iter().all(|step| step.status.is_ok()));
        assert_eq!(steps.last().unwrap().path_point, path.len() - 1);
        assert!(steps.windows(2).all(|pair| pair[1].path_point - pair[0].path_point <= 1));
        let numbers: Vec<usize> = steps.iter().map(|step| step.step).collect();
        assert_eq!(numbers, (1..=steps.len()).collect::<Vec<_>>());
        // Where the target moved on, the policy had arrived: chords between way-points leave the
        // workspace by under 2 mm.
        for pair in steps.windows(2).filter(|pair| pair[1].path_point > pair[0].path_point) {
            assert!(pair[0].error_m < 0.015, "{}: {} m", entry.name, pair[0].error_m);
        }
        println!("{}: {} steps, {} points", entry.name, steps.len(), path.len());
    }
}

#[test]
fn options_out_of_range_are_refused() {
    let bad = ReachOptions { max_steps: 0, ..ReachOptions::default() };
    let target_m = [0.0, 0.0, 0.2];
    assert!(
        reach(
            &mut robot(SHIFT_M),
            &mut Witness::default(),
            &target_m,
            LoopMode::Open,
            &bad,
            Seed(1)
        )
        .is_err()
    );
    let bad = TrackOptions { within_m: Some(0.0), ..TrackOptions::default() };
    assert!(
        track(&mut robot(SHIFT_M), &mut Witness::default(), &[target_m], &bad, Seed(1)).is_err()
    );
}
