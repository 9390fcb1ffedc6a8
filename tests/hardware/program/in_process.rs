//! Tests that need a robot and are started by others, each in a process of its own: what ends it
//! must not end them.

use super::bench::{PLANT, until};
use spinebench::base::{Action, Observation, Plant, Point3, Policy, PolicyError, Seed, distance_m};
use spinebench::plants::Hardware;
use spinebench::specs::{PlantSpec, read_plant};
use spinebench::tasks::{LoopMode, ReachOptions, reach};
use std::path::Path;

/// There once the axes have become so slow that they are still on their way when a step is over.
pub(crate) const SLOWED: &str = "slowed";

/// The robot that whoever started this test has named; none if nobody has.
fn robot() -> Option<Hardware> {
    let file = std::env::var_os(PLANT)?;
    let PlantSpec::Hardware(options) = read_plant(Path::new(&file)).unwrap() else {
        panic!("no robot")
    };
    Some(Hardware::open(&options, 0.2, Seed(1)).unwrap())
}

#[test]
#[ignore = "started by another test"]
fn panics_in_motion() {
    let Some(mut robot) = robot() else { return };
    robot.reset(Seed(1)).unwrap();
    for k in 1..=4 {
        let pull_m = 0.0025 * f64::from(k);
        robot.step(&[pull_m, 0.0, -pull_m, 0.0]).unwrap();
    }
    until(|| Path::new(SLOWED).exists().then_some(()));
    robot.step(&[0.0125, 0.0, -0.0125, 0.0]).unwrap();
    panic!("whoever decides has failed");
}

/// Goes straight for the target, by how far a tendon moves the tip of a robot that bends evenly.
struct Straight {
    pulls_m: [f64; 2],
}

/// Tip over tendon: length over twice the radius of the tendons.
const TIP_PER_PULL: f64 = 0.22 / (2.0 * 0.02);
const STEP_M: f64 = 0.0025;

impl Policy for Straight {
    fn reset(&mut self) {
        self.pulls_m = [0.0; 2];
    }

    fn act(&mut self, seen: &Observation, target_m: &Point3) -> Result<Action, PolicyError> {
        let off_m = [0, 1].map(|axis| target_m[axis] - seen.tip_m[axis]);
        for (pull_m, off_m) in self.pulls_m.iter_mut().zip(off_m) {
            *pull_m += (0.5 * off_m / TIP_PER_PULL).clamp(-STEP_M, STEP_M);
        }
        let [x, y] = self.pulls_m;
        let settled = off_m.iter().all(|off_m| off_m.abs() < 0.001);
        Ok(Action { pulls_m: vec![x, y, -x, -y], settled, branch: "" })
    }
}

#[test]
#[ignore = "started by another test"]
fn reaches_a_target() {
    let Some(mut robot) = robot() else { return };
    let home_m = robot.reset(Seed(1)).unwrap().tip_m;
    let target_m = [home_m[0] + 0.03, home_m[1] + 0.02, home_m[2]];
    let options = ReachOptions { max_steps: 40, ..ReachOptions::default() };
    let mut policy = Straight { pulls_m: [0.0; 2] };
    let outcome =
        reach(&mut robot, &mut policy, &target_m, LoopMode::Closed, &options, Seed(1)).unwrap();
    assert!(outcome.status.is_ok(), "{}", outcome.status);
    let off_m = [0, 1].map(|axis| outcome.tip_m[axis] - target_m[axis]);
    assert!(off_m.iter().all(|off_m| off_m.abs() < 0.004), "{outcome:?}");
    assert!(distance_m(&outcome.tip_m, &home_m) > 0.03 && outcome.steps >= 5, "{outcome:?}");
}
