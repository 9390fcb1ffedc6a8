//! What a controller that counts steps does not know: lost steps, a body that has moved on its
//! mount, a motor that does not turn its screw. The trial is not kept.

use crate::support::rehearsal::{open, options, shipped};
use spinebench::base::{Plant, PlantError, Seed};
use spinebench::hardware::safety::GuardState;
use spinebench::plants::Hardware;
use spinebench::simulators::{ControllerFault, Simulator, TrackerFault};

/// Rows of a trial: a circle of the actuation plane.
const ROWS: usize = 42;

/// A trial in the middle of which `what` happens; what its checks say.
fn trial(plant: &mut Hardware, what: impl FnOnce(&mut Simulator)) -> Result<(), PlantError> {
    plant.reset(Seed(1))?;
    let mut what = Some(what);
    for row in 1..=ROWS {
        if row == ROWS / 2
            && let Some(what) = what.take()
        {
            plant.rehearsal().unwrap().with_simulator(what);
        }
        let angle = 0.15 * row as f64;
        let (x, y) = (0.008 * angle.sin(), 0.008 * (1.0 - angle.cos()));
        plant.step(&[x, y, -x, -y])?;
    }
    plant.verify()
}

fn stopped(found: Result<(), PlantError>, words: &str) {
    let Err(PlantError::Stopped(said)) = found else { panic!("{words}: {found:?}") };
    assert!(said.contains(words) && said.contains("spinebench arm"), "{said}");
}

#[test]
fn a_sound_robot_passes_trial_after_trial() {
    for (model, noise_m, settle_s) in [("nominal", 0.0005, 2.0), ("real", 0.0005, 0.6)] {
        let mut options = options();
        options.settle_s = settle_s;
        let rehearsal = options.rehearsal.as_mut().unwrap();
        (rehearsal.model, rehearsal.noise_m) = (shipped(model), noise_m);
        let mut plant = open(&options, 11);
        for number in 0..4 {
            let found = trial(&mut plant, |_| {});
            assert_eq!(found, Ok(()), "{model}, trial {number}");
        }
    }
}

#[test]
fn steps_that_are_lost_are_found_at_home() {
    let mut plant = open(&options(), 12);
    assert_eq!(trial(&mut plant, |_| {}), Ok(()));
    let lost = ControllerFault::LostSteps(0, 2.0);
    stopped(
        trial(&mut plant, |simulator| simulator.controller.inject(lost)),
        "the rest position of the tip at home differs by ",
    );
    assert!(plant.with_rig(|rig| matches!(rig.state(), GuardState::Stopped { .. })));
    assert!(plant.reset(Seed(2)).is_err(), "a stop is final");
}

/// Not so far that it is a jump.
#[test]
fn a_body_that_moves_on_its_mount_is_found_at_home() {
    let mut plant = open(&options(), 13);
    let moved = TrackerFault::Jump(0.04);
    stopped(trial(&mut plant, |simulator| simulator.tracker.inject(moved)), "differs by 40.0 mm");
}

/// It counts its steps, and home is where it was: only the trial shows it. The first tendon carries
/// the weight of a horizontal robot.
#[test]
fn a_motor_that_does_not_turn_is_named_by_the_trial() {
    for model in ["nominal", "real"] {
        let mut options = options();
        options.rehearsal.as_mut().unwrap().model = shipped(model);
        let mut plant = open(&options, 14);
        plant.reset(Seed(1)).unwrap();
        plant.rehearsal().unwrap().with_simulator(|simulator| {
            simulator.controller.inject(ControllerFault::SlippingAxis(0));
        });
        stopped(trial(&mut plant, |_| {}), "axis X (tendon 1) did not move its tendon");
    }
}
