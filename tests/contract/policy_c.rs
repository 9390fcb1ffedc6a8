//! When the hybrid changes its controller, and that it comes to an end.

use std::sync::Arc;

use crate::support::policies::{
    AnalyticInverse, ConstantError, exact_parts, negative, policy, reachable, robot, seen,
};
use spinebench::base::{Point3, Seed};
use spinebench::policies::{
    AfterBoth, INVERSE, INVERSE_B, PolicyOptions, PolicyParts, StartBranch, SwitchCheck,
};
use spinebench::tasks::{LoopMode, ReachOptions, ReachOutcome, reach};

const SHIFT_M: Point3 = [-0.012, 0.004, 0.0];
const TARGET_PULLS_M: (f64, f64) = (0.012, -0.008);

/// A hybrid whose A errs by about `a_m` and whose B by about `b_m` in y, on a robot shifted by
/// `SHIFT_M`.
fn parts(a_m: f64, b_m: f64) -> PolicyParts {
    let [x, y, z] = negative(SHIFT_M);
    let [shift_x, shift_y, shift_z] = SHIFT_M;
    let generated = AnalyticInverse {
        shift_m: [shift_x, shift_y - b_m, shift_z],
        ..AnalyticInverse::default()
    };
    PolicyParts::default()
        .with_inverse(&INVERSE, Box::new(AnalyticInverse::default()))
        .with_inverse(&INVERSE_B, Box::new(generated))
        .with_error(Arc::new(ConstantError([x, y + a_m, z])))
}

fn run(parts: PolicyParts, options: &PolicyOptions) -> ReachOutcome {
    let target_m = reachable(TARGET_PULLS_M.0, TARGET_PULLS_M.1, SHIFT_M);
    let mut c = policy("c", parts, options);
    let options = ReachOptions::default();
    let outcome =
        reach(&mut robot(SHIFT_M), c.as_mut(), &target_m, LoopMode::Closed, &options, Seed(1))
            .unwrap();
    assert!(outcome.status.is_ok(), "{}", outcome.status);
    outcome
}

#[test]
fn where_a_is_good_c_is_a() {
    let target_m = reachable(TARGET_PULLS_M.0, TARGET_PULLS_M.1, SHIFT_M);
    let mut a = policy("a", parts(0.005, 0.0), &PolicyOptions::default());
    let options = ReachOptions::default();
    let by_a =
        reach(&mut robot(SHIFT_M), a.as_mut(), &target_m, LoopMode::Closed, &options, Seed(1))
            .unwrap();
    let by_c = run(parts(0.005, 0.0), &PolicyOptions::default());
    assert_eq!(by_c.switches, 0);
    assert_eq!(by_c, by_a);
}

#[test]
fn where_a_errs_by_more_than_e_c_b_takes_over_once() {
    let outcome = run(parts(0.03, 0.001), &PolicyOptions::default());
    assert_eq!(outcome.switches, 1);
    assert!(outcome.settled);
    assert!(outcome.error_m < 0.003, "{} m", outcome.error_m);
}

#[test]
fn the_threshold_decides() {
    // A alone ends at this error; e_c just above and just below it.
    let mut never = PolicyOptions::default();
    never.c.max_switches = 0;
    let error_m = run(parts(0.03, 0.0), &never).error_m;
    assert!(error_m > 0.015, "{error_m} m");
    for (factor, switches) in [(1.02, 0), (0.98, 1)] {
        let mut options = PolicyOptions::default();
        options.c.switch_threshold_m = factor * error_m;
        assert_eq!(run(parts(0.03, 0.0), &options).switches, switches);
    }
}

#[test]
fn where_both_err_the_better_one_is_kept() {
    let a_better = run(parts(0.03, 0.05), &PolicyOptions::default());
    assert_eq!(a_better.switches, 2, "A, then B, then back to A");
    assert!(a_better.settled);
    let b_better = run(parts(0.05, 0.03), &PolicyOptions::default());
    assert_eq!(b_better.switches, 1, "A, then B");
    assert!(b_better.settled);
    let mut never = PolicyOptions::default();
    never.c.max_switches = 0;
    let a_alone = run(parts(0.03, 0.05), &never);
    assert!((a_better.error_m - a_alone.error_m).abs() < 1e-6);
    let mut stay = PolicyOptions::default();
    stay.c.after_both = AfterBoth::Stay;
    assert_eq!(run(parts(0.03, 0.05), &stay).switches, 1);
}

#[test]
fn alternating_ends_with_the_changes() {
    let mut options = PolicyOptions::default();
    options.c.after_both = AfterBoth::Alternate;
    options.c.max_switches = 4;
    let outcome = run(parts(0.03, 0.05), &options);
    assert_eq!(outcome.switches, 4);
    assert!(outcome.settled);
}

#[test]
fn the_same_command_is_no_reason_to_change() {
    // B errs exactly as A does: L_A = L_B although the error is large.
    let outcome = run(parts(0.03, 0.03), &PolicyOptions::default());
    assert_eq!(outcome.switches, 0);
    assert!(outcome.settled);
    assert!(outcome.error_m > 0.015);
}

#[test]
fn a_controller_that_never_settles_loses_its_turn() {
    // A's network drifts at every tick by more than the tip's tolerance allows to rest.
    let drifting = AnalyticInverse { drift_m: 0.0005, ..AnalyticInverse::default() };
    let parts = parts(0.03, 0.0).with_inverse(&INVERSE, Box::new(drifting));
    let mut options = PolicyOptions::default();
    options.c.leg_ticks = 10;
    options.limits.max_step_m = None;
    let mut c = policy("c", parts, &options);
    let target_m = [0.06, 0.0, 0.2];
    let branches: Vec<&str> = (0..20)
        .map(|step| {
            let tip_m = [0.003 * (step % 2) as f64, 0.0, 0.22];
            c.act(&seen(step, tip_m), &target_m).unwrap().branch
        })
        .collect();
    assert_eq!(branches[..10], ["a"; 10]);
    assert_eq!(branches[10], "b");
}

#[test]
fn a_moving_tip_is_not_a_final_error() {
    let mut options = PolicyOptions::default();
    options.limits.max_step_m = None;
    let mut c = policy("c", exact_parts(SHIFT_M), &options);
    let target_m = [0.08, 0.0, 0.2];
    for step in 0..20 {
        // 3 mm a tick, always farther than e_c: A has long settled, but the robot is on its way.
        let action = c.act(&seen(step, [0.003 * step as f64, 0.0, 0.22]), &target_m).unwrap();
        assert_eq!(action.branch, "a");
        assert!(!action.settled);
    }
}

#[test]
fn a_new_target_starts_as_told() {
    for (start, branch) in [(StartBranch::A, "a"), (StartBranch::Last, "b")] {
        let mut options = PolicyOptions::default();
        options.c.start = start;
        options.limits.max_step_m = None;
        let mut c = policy("c", exact_parts(SHIFT_M), &options);
        let stuck_m = [0.0, 0.0, 0.22];
        let branches: Vec<&str> = (0..6)
            .map(|step| c.act(&seen(step, stuck_m), &[0.05, 0.0, 0.21]).unwrap().branch)
            .collect();
        // L_A and L_B agree for a constant gap, so the change has to be forced by another B.
        assert!(branches.iter().all(|name| *name == "a"));
        let mut c = policy("c", parts(0.0, 0.03), &options);
        let branches: Vec<&str> = (0..6)
            .map(|step| c.act(&seen(step, stuck_m), &[0.05, 0.0, 0.21]).unwrap().branch)
            .collect();
        assert_eq!(*branches.last().unwrap(), "b");
        assert_eq!(c.act(&seen(6, stuck_m), &[0.0, 0.05, 0.21]).unwrap().branch, branch);
    }
}

#[test]
fn checking_at_every_tick_follows_the_error() {
    let mut options = PolicyOptions::default();
    options.c.check = SwitchCheck::EveryTick;
    options.c.max_switches = 10;
    let mut c = policy("c", parts(0.0, 0.03), &options);
    let target_m = [0.05, 0.0, 0.21];
    let mut branch = |step: usize, away_m: f64| {
        c.act(&seen(step, [target_m[0] - away_m, 0.0, 0.21]), &target_m).unwrap().branch
    };
    assert_eq!(
        [branch(0, 0.02), branch(1, 0.01), branch(2, 0.0151), branch(3, 0.0149)],
        ["b", "a", "b", "a"]
    );
}
