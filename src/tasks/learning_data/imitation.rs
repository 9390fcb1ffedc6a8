//! Data for imitation: a policy goes its own way to a target, and each tick is labelled with the
//! command that has the tip there (Ross, Gordon & Bagnell 2011).

use rand::RngExt;

use crate::base::{Displacements, Plant, Point3, Policy, Seed};
use crate::tasks::record::actuation::{BendMap, drive_to};
use crate::tasks::{ExploreOptions, TaskError, Transitions};

/// A tip and the command under which a robot had it there.
#[derive(Clone, Debug, PartialEq)]
pub struct ReachedPose {
    /// The tip, metres.
    pub tip_m: Point3,
    /// The displacements of all tendons, metres.
    pub pulls_m: Displacements,
}

/// Drives a robot to `count` random bends within the travel of an exploration, and records what it
/// reaches. Use a robot without measurement noise.
///
/// # Errors
/// [`TaskError`] for a setting out of range, or a plant that fails.
pub fn reached_poses(
    robot: &mut dyn Plant,
    options: &ExploreOptions,
    count: usize,
    seed: Seed,
) -> Result<Vec<ReachedPose>, TaskError> {
    options.check()?;
    let map = BendMap::of(robot)?;
    let mut random = seed.child("bends").rng();
    let mut observation = robot.reset(seed.child("poses"))?;
    let mut bend_m = map.straight();
    let mut poses = Vec::with_capacity(count);
    for _ in 0..count {
        let range_m = -options.max_pull_m..=options.max_pull_m;
        let next_m = bend_m.iter().map(|_| random.random_range(range_m.clone())).collect();
        if let Some(reached) = drive_to(robot, &map, &mut bend_m, next_m, options.max_step_m)? {
            // No step, no new observation: the robot is there already.
            observation = reached;
        }
        poses.push(ReachedPose { tip_m: observation.tip_m, pulls_m: observation.pulls_m.clone() });
    }
    Ok(poses)
}

/// The ways of a policy from rest at home to each of the poses, `ticks` long: a trajectory each,
/// with the tip before a tick, the target, and the target's command as the displacement. A way ends
/// early where the policy has no answer.
///
/// # Errors
/// [`TaskError::Plant`] for a plant that fails.
pub fn imitate(
    robot: &mut dyn Plant,
    policy: &mut dyn Policy,
    poses: &[ReachedPose],
    ticks: usize,
    seed: Seed,
) -> Result<Transitions, TaskError> {
    let mut samples = Transitions::begin(robot.tendons());
    samples.starts.clear();
    for (index, pose) in poses.iter().enumerate() {
        let mut observation = robot.reset(seed.child("ways").index(index as u64))?;
        policy.reset();
        samples.starts.push(samples.len());
        for _ in 0..ticks {
            samples.from_m.push(&observation.tip_m);
            samples.pulls_m.push(&pose.pulls_m);
            samples.to_m.push(&pose.tip_m);
            // DAgger: the policy chooses the states that are visited, the pose the label.
            let Ok(action) = policy.act(&observation, &pose.tip_m) else { break };
            observation = robot.step(&action.pulls_m)?;
        }
    }
    Ok(samples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Action, Observation, PolicyError};
    use crate::plants::PlantSpec;

    /// Demands nothing.
    struct Idle;

    impl Policy for Idle {
        fn reset(&mut self) {}

        fn act(
            &mut self,
            observation: &Observation,
            _target_m: &Point3,
        ) -> Result<Action, PolicyError> {
            Ok(Action { pulls_m: vec![0.0; observation.pulls_m.len()], settled: false, branch: "" })
        }
    }

    #[test]
    fn every_tick_of_a_way_is_labelled_with_the_command_of_its_target() {
        let spec = PlantSpec::ConstantCurvature(Box::default());
        let mut robot = spec.build(0.2).unwrap();
        let poses = reached_poses(robot.as_mut(), &ExploreOptions::default(), 3, Seed(4)).unwrap();
        let home_m = robot.reset(Seed(0)).unwrap().tip_m;
        let samples = imitate(robot.as_mut(), &mut Idle, &poses, 5, Seed(5)).unwrap();
        assert_eq!((samples.len(), samples.starts.as_slice()), (15, [0, 5, 10].as_slice()));
        for row in 0..15 {
            assert_eq!(samples.pulls_m.row(row), poses[row / 5].pulls_m, "{row}");
            assert_eq!(samples.to_m.row(row), poses[row / 5].tip_m, "{row}");
            assert!(
                crate::base::distance_m(&home_m, samples.from_m.row(row).try_into().unwrap())
                    < 1e-9,
                "{row}"
            );
        }
    }
}
