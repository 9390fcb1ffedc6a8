//! A submitted policy on requests near home, before it plays.

use super::common::STEP_S;
use spinebench::base::{Observation, Policy, Seed};
use spinebench::league::board::TickTimes;
use spinebench::league::robot::LeagueRobot;
use spinebench::league::submission::{ReadSubmission, SubmittedPolicy};
use spinebench::league::track::ReadTrack;
use spinebench::math::summary::quantile;
use spinebench::plants::{PlantSpec, SimulatedSpec};
use spinebench::policies::{OutsidePolicy, PolicyOptions, ProcessOptions};
use spinebench::tasks::policy_samples;
use std::collections::BTreeMap;
use std::time::Instant;

/// How a policy runs that plays a track.
pub(super) fn confined(track: &ReadTrack) -> ProcessOptions {
    ProcessOptions { confined: true, answer_s: track.track.answer_s, ..ProcessOptions::default() }
}

/// Number of answers whose time is measured on each robot.
const TIMED: usize = 20;

/// Starts the policy for each number of tendons and asks it the same twice.
pub(super) fn tried(
    policy: &SubmittedPolicy,
    read: &ReadSubmission,
    track: &ReadTrack,
    robots: &[LeagueRobot],
) -> Result<Option<TickTimes>, Vec<String>> {
    let Some(outside) = policy.outside(&read.folder) else { return Ok(None) };
    let mut faults = Vec::new();
    let budget = track.track.samples;
    if outside.samples() > budget {
        faults.push(format!(
            "policy.{}.samples: found {}, expected at most {budget}, the budget of the track",
            policy.kind(),
            outside.samples()
        ));
    }
    if let Err(missing) = super::confine::guards() {
        faults.push(format!("this machine: {missing}"));
        return Err(faults);
    }
    let kinds: BTreeMap<usize, &LeagueRobot> =
        robots.iter().map(|robot| (robot.plant.tendons(), robot)).collect();
    let mut times_s = Vec::new();
    for (tendons, robot) in kinds {
        match answers(&outside, track, robot, tendons, &mut times_s)
            .and_then(|first| Ok((first, answers(&outside, track, robot, tendons, &mut times_s)?)))
        {
            Err(fault) => {
                faults.push(format!("policy: {tendons} tendons ({}): {fault}", robot.family))
            }
            Ok((first, second)) if first != second => {
                faults.push(format!("policy: {tendons} tendons ({}): found other answers the second time, expected the same for the same requests", robot.family));
            }
            Ok(_) => {}
        }
    }
    let times = TickTimes { median_s: quantile(&times_s, 0.5), p95_s: quantile(&times_s, 0.95) };
    if faults.is_empty() { Ok(Some(times)) } else { Err(faults) }
}

/// What a policy that was just started answers about points near home.
fn answers(
    outside: &OutsidePolicy,
    track: &ReadTrack,
    robot: &LeagueRobot,
    tendons: usize,
    times_s: &mut Vec<f64>,
) -> Result<Vec<Vec<f64>>, String> {
    let process = confined(track);
    let content = std::fs::read(outside.file()).map_err(|error| error.to_string())?;
    let checked = outside.check_content(&content, tendons, &process);
    checked.map_err(|(found, expected)| format!("found {found}, expected {expected}"))?;
    let options = PolicyOptions { process, ..PolicyOptions::default() };
    let mut policy: Box<dyn Policy> = outside.build(&content, tendons, &options)?;
    // Samples of the nominal robot: the robots of the track are for its score.
    let nominal = PlantSpec::Simulated(Box::new(SimulatedSpec::new(robot.nominal.clone(), 0.0)));
    let max_step_m = Some(0.1 * robot.travel_m());
    let failed =
        policy_samples(nominal.build(STEP_S)?.as_mut(), policy.as_mut(), max_step_m, Seed(0))
            .map_err(|error| error.to_string())?;
    if let Some(fault) = failed {
        return Err(format!("sample: {fault}"));
    }
    policy.reset();
    let length_m = robot.length_m();
    let mut seen = Observation {
        time_s: 0.0,
        tip_m: [0.0, 0.0, length_m],
        tip_quaternion: None,
        points: Vec::new(),
        pulls_m: vec![0.0; tendons],
        tensions_n: None,
        valid: true,
    };
    let mut answers = Vec::with_capacity(TIMED);
    for tick in 0..TIMED {
        let angle = tick as f64;
        let target_m =
            [0.1 * length_m * angle.cos(), 0.1 * length_m * angle.sin(), 0.99 * length_m];
        let began = Instant::now();
        let action = policy.act(&seen, &target_m).map_err(|error| error.to_string())?;
        times_s.push(began.elapsed().as_secs_f64());
        seen.time_s += STEP_S;
        seen.pulls_m.clone_from(&action.pulls_m);
        answers.push(action.pulls_m);
    }
    Ok(answers)
}
