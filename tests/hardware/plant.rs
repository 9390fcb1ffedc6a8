//! The hardware plant on imitated motors and an imitated tracker, through the real drivers.

use crate::support::rehearsal::{STEP_S, open, options, shipped};
use spinebench::base::{Plant, PlantError, Seed, distance_m};
use spinebench::hardware::safety::GuardState;
use spinebench::plants::{Simulated, SimulatedOptions};
use spinebench::simulators::{Simulator, TrackerFault};
use spinebench::tasks::{ExploreOptions, explore};

/// What lead screws that take most of a tick, and a pose up to a frame old, make of a step of 3 mm,
/// metres.
const LAG_M: f64 = 0.004;

#[test]
fn an_exploration_is_that_of_the_simulated_robot() {
    let options = options();
    let explored = ExploreOptions { points: 150, ..ExploreOptions::default() };
    let mut simulated = Simulated::new(&shipped("nominal"), &[], SimulatedOptions::default());
    let expected = explore(&mut simulated, &explored, Seed(5)).unwrap();
    let mut plant = open(&options, 1);
    let seen = explore(&mut plant, &explored, Seed(5)).unwrap();
    let off: Vec<f64> = (0..seen.len())
        .map(|row| {
            let [a, b] =
                [&seen, &expected].map(|samples| [0, 1, 2].map(|axis| samples.to_m.row(row)[axis]));
            distance_m(&a, &b)
        })
        .collect();
    let rms_m = (off.iter().map(|off_m| off_m * off_m).sum::<f64>() / off.len() as f64).sqrt();
    let largest_m = off.iter().copied().fold(0.0, f64::max);
    let sums = seen.pulls_m.iter().flat_map(|pulls| [pulls[0] + pulls[2], pulls[1] + pulls[3]]);
    let (low, high) =
        sums.fold((0.0_f64, 0.0_f64), |(low, high), sum| (low.min(sum), high.max(sum)));
    println!("opposite tendons together from {low:.4} to {high:.4} m");
    println!("rms {rms_m:.5} m, largest {largest_m:.5} m, {:?}", plant.events());
    assert!(rms_m < LAG_M && largest_m < 3.0 * LAG_M, "{rms_m} m, {largest_m} m");
    assert_eq!((plant.timing().missed, plant.timing().held), (0, 0));
    assert!(plant.with_rig(|rig| *rig.state() == GuardState::Active));
}

#[test]
fn a_reset_brings_the_robot_home_from_anywhere() {
    let mut plant = open(&options(), 2);
    let home = plant.reset(Seed(0)).unwrap();
    assert!(home.valid && home.time_s < 0.02);
    for k in 1..=6 {
        let pull_m = 0.002 * f64::from(k);
        let seen = plant.step(&[pull_m, 0.5 * pull_m, -pull_m, -0.5 * pull_m]).unwrap();
        assert!((seen.time_s - STEP_S * f64::from(k)).abs() < 0.02, "{}", seen.time_s);
    }
    let again = plant.reset(Seed(0)).unwrap();
    assert!(distance_m(&again.tip_m, &home.tip_m) < 2e-4, "{:?} {:?}", again.tip_m, home.tip_m);
}

/// Wherever the switches are, home and pulls are the same distances from them.
#[test]
fn switches_at_upper_ends_are_the_same_robot() {
    let seen = |homing_directions: u8| {
        let mut options = options();
        options.motion.homing_directions = homing_directions;
        let mut plant = open(&options, 6);
        plant.reset(Seed(0)).unwrap();
        let tip_m = plant.step(&[0.003, 0.001, -0.003, -0.001]).unwrap().tip_m;
        plant.step(&[0.003, 0.001, -0.003, -0.001]).unwrap();
        let screws_mm = plant
            .rehearsal()
            .unwrap()
            .with_simulator(|simulator| simulator.controller.position_mm());
        (tip_m, screws_mm, plant.with_rig(|rig| rig.controller().state().position_mm))
    };
    let [lower, upper, mixed] = [15, 0, 6].map(seen);
    assert_eq!(lower.2, [33.0, 31.0, 27.0, 29.0]);
    assert_eq!(upper.2, [-33.0, -31.0, -27.0, -29.0]);
    assert_eq!(mixed.2, [-33.0, 31.0, 27.0, -29.0]);
    assert_eq!((lower.1, lower.1), (upper.1, mixed.1));
    // While the tip moves, it is seen a look of the watch earlier or later.
    for tip_m in [upper.0, mixed.0] {
        assert!(distance_m(&tip_m, &lower.0) < 0.002, "{tip_m:?} {:?}", lower.0);
    }
}

#[test]
fn what_may_not_leave_is_refused_and_the_robot_goes_on() {
    let mut plant = open(&options(), 3);
    plant.reset(Seed(0)).unwrap();
    let refused = |outcome: Result<_, PlantError>| {
        assert!(matches!(outcome, Err(PlantError::Refused(_))), "{outcome:?}")
    };
    refused(plant.step(&[0.0121, 0.0, 0.0, 0.0]));
    refused(plant.step(&[f64::NAN, 0.0, 0.0, 0.0]));
    refused(plant.step(&[f64::INFINITY, 0.0, 0.0, 0.0]));
    refused(plant.step(&[0.0; 3]));
    // Two steps at once take two ticks.
    let far = plant.step(&[0.006, 0.0, -0.004, 0.0]).unwrap();
    assert!(
        (far.time_s - 2.0 * STEP_S).abs() < 0.05 && far.pulls_m == [0.006, 0.0, -0.004, 0.0],
        "{far:?}"
    );
    for k in 1..=9 {
        plant.step(&[0.003 * f64::from(k), 0.0, -0.003 * f64::from(k), 0.0]).unwrap();
    }
    plant.step(&[0.03, 0.0, -0.03, 0.0]).unwrap();
    refused(plant.step(&[0.031, 0.0, -0.03, 0.0]));
    plant.step(&[0.028, 0.0, -0.028, 0.0]).unwrap();
}

#[test]
fn lost_frames_do_not_hold_the_robot() {
    let mut options = options();
    options.rehearsal.as_mut().unwrap().loss = 0.01;
    let mut plant = open(&options, 4);
    plant.reset(Seed(0)).unwrap();
    for k in 0..400 {
        let angle = 0.05 * f64::from(k);
        let (x, y) = (0.01 * angle.sin(), 0.01 * (1.0 - angle.cos()));
        assert!(plant.step(&[x, y, -x, -y]).unwrap().valid);
    }
    let lost = plant.with_rig(|rig| rig.tracking().status().lost);
    assert!(lost > 20, "{lost}");
    assert_eq!((plant.timing().missed, plant.timing().held), (0, 0));
}

/// Whoever decides has taken too long: the next row would be measured later than it says.
#[test]
fn a_late_tick_ends_the_trial_and_a_hold_does_not() {
    let mut plant = open(&options(), 5);
    plant.reset(Seed(0)).unwrap();
    plant.step(&[0.002, 0.0, -0.002, 0.0]).unwrap();
    plant.run_diagnostics(0.05);
    plant.step(&[0.003, 0.0, -0.003, 0.0]).unwrap();
    plant.run_diagnostics(0.5);
    let late = plant.step(&[0.004, 0.0, -0.004, 0.0]).unwrap_err();
    assert!(matches!(late, PlantError::Late(_)) && late.to_string().contains("500 ms"), "{late}");
    // The robot is as it was, and the next trial is a new one.
    plant.reset(Seed(0)).unwrap();
    assert!(plant.with_rig(|rig| *rig.state() == GuardState::Active));
    plant.step(&[0.002, 0.0, -0.002, 0.0]).unwrap();
    // A robot that is held waits: nothing is late.
    let now_s = plant.now_s();
    plant.rehearsal().unwrap().with_simulator(|simulator| {
        let silent = |simulator: &mut Simulator| simulator.tracker.inject(TrackerFault::Silent);
        simulator.schedule(now_s + 0.1, Box::new(silent));
        let clear = |simulator: &mut Simulator| simulator.tracker.clear_faults();
        simulator.schedule(now_s + 0.3, Box::new(clear));
    });
    for k in 0..5 {
        plant.step(&[0.002 + 0.001 * f64::from(k), 0.0, -0.002, 0.0]).unwrap();
    }
    assert!(plant.timing().held > 0);
}
