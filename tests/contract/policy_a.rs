//! Algorithm 2 against gaps whose fixed point is known.

use std::sync::Arc;

use crate::support::policies::{
    AnalyticInverse, ConstantError, GrowingError, exact_parts, policy, reachable, robot, seen,
};
use spinebench::base::{Plant, Point3, Seed, distance_m};
use spinebench::policies::{INVERSE, MemoryUpdate, PolicyOptions, PolicyParts};
use spinebench::tasks::{
    LoopMode, PathOptions, ReachOptions, TrackOptions, interpolate, reach, track, waypoints,
};

const SHIFT_M: Point3 = [-0.012, 0.004, 0.0];

#[test]
fn a_known_constant_gap_is_closed_in_both_modes() {
    let target_m = reachable(0.015, -0.01, SHIFT_M);
    for mode in [LoopMode::Open, LoopMode::Closed] {
        let mut a = policy("a", exact_parts(SHIFT_M), &PolicyOptions::default());
        let outcome = reach(
            &mut robot(SHIFT_M),
            a.as_mut(),
            &target_m,
            mode,
            &ReachOptions::default(),
            Seed(1),
        )
        .unwrap();
        assert!(outcome.status.is_ok(), "{}", outcome.status);
        assert!(outcome.settled);
        assert!(outcome.error_m < 1e-4, "{mode:?}: {} m", outcome.error_m);
    }
}

#[test]
fn without_the_error_model_the_gap_stays() {
    let target_m = reachable(0.015, -0.01, SHIFT_M);
    let parts = exact_parts(SHIFT_M).with_error(Arc::new(ConstantError([0.0; 3])));
    let mut a = policy("a", parts, &PolicyOptions::default());
    let options = ReachOptions::default();
    let outcome =
        reach(&mut robot(SHIFT_M), a.as_mut(), &target_m, LoopMode::Closed, &options, Seed(1))
            .unwrap();
    // The inverse aims at a point off the workspace and hits the one in its direction: the gap, to
    // a projection.
    assert!((0.005..0.02).contains(&outcome.error_m), "{} m", outcome.error_m);
}

/// x_s = x_real + g x_s has the fixed point x_real / (1 − g), approached by the factor g in an
/// iteration; the loop ends when a correction g^i · g·x falls to 1 mm.
#[test]
fn the_fixed_point_is_found_in_as_many_iterations_as_the_contraction_says() {
    let gain = 0.5;
    let mut options = PolicyOptions::default();
    options.limits.max_step_m = None;
    let parts = PolicyParts::default()
        .with_inverse(&INVERSE, Box::new(AnalyticInverse::default()))
        .with_error(Arc::new(GrowingError(gain)));
    let mut a = policy("a", parts, &options);
    let target_m = [0.02, 0.0, 0.2];
    let tip_m = [0.0, 0.0, 0.22];
    // Corrections: 10, 5, 2.5, 1.25, 0.625 mm.
    let settled: Vec<bool> =
        (0..6).map(|step| a.act(&seen(step, tip_m), &target_m).unwrap().settled).collect();
    assert_eq!(settled, [false, false, false, false, true, true]);
    let last = (6..60).map(|step| a.act(&seen(step, tip_m), &target_m).unwrap()).last().unwrap();
    let fixed_point_m = [target_m[0] / (1.0 - gain), 0.0, target_m[2]];
    let expected = AnalyticInverse::default();
    let expected =
        spinebench::policies::InverseModel::pulls(&mut expected.clone(), &tip_m, &fixed_point_m)
            .unwrap();
    for (found, expected) in last.pulls_m.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9);
    }
}

#[test]
fn several_iterations_in_a_tick_are_as_many_ticks_without_new_measurement() {
    let parts = || {
        PolicyParts::default()
            .with_inverse(&INVERSE, Box::new(AnalyticInverse::default()))
            .with_error(Arc::new(GrowingError(0.5)))
    };
    let mut options = PolicyOptions::default();
    options.limits.max_step_m = None;
    let target_m = [0.02, 0.0, 0.2];
    let home = seen(0, [0.0, 0.0, 0.22]);
    let mut slow = policy("a", parts(), &options);
    let slowly = (0..5).map(|_| slow.act(&home, &target_m).unwrap()).last().unwrap();
    options.a.iterations_per_tick = 50;
    let at_once = policy("a", parts(), &options).act(&home, &target_m).unwrap();
    assert!(at_once.settled);
    assert_eq!(at_once, slowly);
}

/// The command for a further target, on a robot whose gap is the same everywhere.
#[test]
fn a_new_target_starts_from_itself_unless_warm() {
    let mut options = PolicyOptions::default();
    options.limits.max_step_m = None;
    let (first_m, second_m) = ([0.02, 0.0, 0.2], [0.03, 0.0, 0.2]);
    let mut next_pull_m = |warm_start| {
        options.a.warm_start = warm_start;
        let mut a = policy("a", exact_parts(SHIFT_M), &options);
        for step in 0..5 {
            a.act(&seen(step, [0.0, 0.0, 0.22]), &first_m).unwrap();
        }
        let action = a.act(&seen(5, [0.0, 0.0, 0.22]), &second_m).unwrap();
        assert!(!action.settled, "the criterion counts from the second iteration");
        action.pulls_m[0]
    };
    let inverse = |to_m: Point3| {
        spinebench::policies::InverseModel::pulls(&mut AnalyticInverse::default(), &[0.0; 3], &to_m)
            .unwrap()[0]
    };
    assert_eq!(next_pull_m(false), inverse(second_m));
    assert_eq!(
        next_pull_m(true),
        inverse([second_m[0] - SHIFT_M[0], second_m[1] - SHIFT_M[1], second_m[2]])
    );
}

#[test]
fn along_a_path_the_printed_guess_kicks_the_robot_at_every_point() {
    let path_options = PathOptions::default();
    let path = interpolate(
        &waypoints(&mut robot(SHIFT_M), &path_options, Seed(1)).unwrap(),
        &path_options,
    )
    .unwrap();
    let mean_error_m = |warm_start| {
        let mut options = PolicyOptions::default();
        options.a.warm_start = warm_start;
        let mut a = policy("a", exact_parts(SHIFT_M), &options);
        let steps =
            track(&mut robot(SHIFT_M), a.as_mut(), &path, &TrackOptions::default(), Seed(1))
                .unwrap();
        let on_path: Vec<f64> =
            steps.iter().filter(|step| step.path_point > 0).map(|step| step.error_m).collect();
        on_path.iter().sum::<f64>() / on_path.len() as f64
    };
    let (printed_m, warm_m) = (mean_error_m(false), mean_error_m(true));
    println!("mean tracking error of A: printed guess {printed_m} m, warm {warm_m} m");
    assert!(warm_m < 0.002 && printed_m > 0.004);
}

/// An inverse that says where it thinks the robot is.
struct Position;
impl spinebench::policies::InverseModel for Position {
    fn reset(&mut self) {}
    fn pulls(
        &mut self,
        from_m: &Point3,
        _to_m: &Point3,
    ) -> Result<Vec<f64>, spinebench::base::PolicyError> {
        Ok(vec![from_m[0], from_m[1], 0.0, 0.0])
    }
}

#[test]
fn the_position_is_moved_by_the_last_error_and_stays_in_open_loop() {
    let parts = || {
        PolicyParts::default()
            .with_inverse(&INVERSE, Box::new(Position))
            .with_error(Arc::new(ConstantError([0.003, 0.0, 0.0])))
    };
    let mut options = PolicyOptions::default();
    options.limits.max_step_m = None;
    let target_m = [0.02, 0.0, 0.2];
    let mut closed = policy("a", parts(), &options);
    assert_eq!(closed.act(&seen(0, [0.001, 0.0, 0.2]), &target_m).unwrap().pulls_m[0], 0.001);
    assert_eq!(closed.act(&seen(1, [0.002, 0.0, 0.2]), &target_m).unwrap().pulls_m[0], 0.005);
    let mut open = policy("a", parts(), &options);
    for _ in 0..3 {
        assert_eq!(open.act(&seen(0, [0.001, 0.0, 0.2]), &target_m).unwrap().pulls_m[0], 0.001);
    }
}

#[test]
fn memory_moves_when_it_is_told_to() {
    let drift_m = 1e-4;
    let ticks_after_three = |memory, frozen: bool| {
        let mut options = PolicyOptions::default();
        options.network.memory = memory;
        options.limits.max_step_m = None;
        let parts = PolicyParts::default()
            .with_inverse(
                &INVERSE,
                Box::new(AnalyticInverse { drift_m, ..AnalyticInverse::default() }),
            )
            .with_error(Arc::new(ConstantError([0.0; 3])));
        let mut a = policy("a", parts, &options);
        let pull_m: Vec<f64> = (0..3)
            .map(|step| {
                a.act(&seen(if frozen { 0 } else { step }, [0.0, 0.0, 0.22]), &[0.0, 0.0, 0.22])
                    .unwrap()
            })
            .map(|action| action.pulls_m[0])
            .collect();
        (pull_m[2] / drift_m).round()
    };
    assert_eq!(ticks_after_three(MemoryUpdate::Measured, false), 2.0);
    assert_eq!(ticks_after_three(MemoryUpdate::Measured, true), 0.0);
    assert_eq!(ticks_after_three(MemoryUpdate::EveryTick, true), 2.0);
    assert_eq!(ticks_after_three(MemoryUpdate::Rest, false), 0.0);
}

#[test]
fn a_limited_lookahead_reaches_the_same_place() {
    let target_m = reachable(0.02, 0.0, SHIFT_M);
    let mut options = PolicyOptions::default();
    options.network.lookahead_m = Some(0.01);
    let mut a = policy("a", exact_parts(SHIFT_M), &options);
    let mut plant = robot(SHIFT_M);
    let outcome = reach(
        &mut plant,
        a.as_mut(),
        &target_m,
        LoopMode::Closed,
        &ReachOptions::default(),
        Seed(1),
    )
    .unwrap();
    assert!(outcome.error_m < 1e-3, "{} m", outcome.error_m);
    assert!(
        distance_m(&plant.reset(Seed(1)).unwrap().tip_m, &target_m) > 0.05,
        "the target is far"
    );
}
