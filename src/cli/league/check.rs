//! `spinebench league check`.

use super::common::{Robots, SeasonArgs};
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::base::{Observation, Policy, Seed};
use spinebench::league::answers::judge;
use spinebench::league::board::TickTimes;
use spinebench::league::questions::recordings;
use spinebench::league::robot::LeagueRobot;
use spinebench::league::submission::{ReadSubmission, SubmittedPolicy};
use spinebench::league::track::{ReadTrack, Task};
use spinebench::math::summary::quantile;
use spinebench::plants::{PlantSpec, SimulatedSpec};
use spinebench::policies::{OutsidePolicy, PolicyOptions, ProcessOptions};
use spinebench::tasks::policy_samples;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// Report everything that is wrong with a submission, at once.
#[derive(Args)]
pub(crate) struct CheckCommand {
    /// Folder of the submission, with `submission.yaml`.
    folder: PathBuf,
    #[command(flatten)]
    season: SeasonArgs,
}

impl CheckCommand {
    pub(crate) fn execute(&self) -> CommandResult {
        let robots = self.season.robots()?;
        let checked = CheckedSubmission::read(&self.folder, &self.season, &robots)?;
        let has_questions = recordings(&checked.track.track.task).is_some();
        if let (true, Some(answers)) = (has_questions, &checked.read.submission.answers) {
            judge(&checked.track, &checked.robots, &self.folder.join(answers))?;
        }
        let times =
            checked.times.map(|times| format!(", {:.1} ms an answer", 1e3 * times.median_s));
        let submission = &checked.read.submission;
        let policy = submission.policy.as_ref();
        let mut outside = policy.and_then(|policy| policy.outside(&self.folder));
        if let Some(outside) = &mut outside {
            outside.read_attributes(&confined(&checked.track));
        }
        let has_open = matches!(&checked.track.track.task, Task::Reach { modes } if modes.iter().any(|mode| mode == "open"));
        let closed_only = if has_open
            && outside.is_some_and(|outside| outside.entry().closed_loop_only)
        {
            "; closed loop alone: the mode `open` is not played, so it has no rank over all modes"
        } else {
            ""
        };
        println!(
            "`{}` is ready for the track `{}`: {} robots{}{closed_only}",
            submission.name,
            checked.track.name,
            checked.robots.len(),
            times.unwrap_or_default()
        );
        Ok(())
    }
}

/// A submission without faults, its track and robots, and how fast its policy answers.
pub(super) struct CheckedSubmission {
    pub(super) read: ReadSubmission,
    pub(super) track: ReadTrack,
    pub(super) robots: Vec<LeagueRobot>,
    pub(super) times: Option<TickTimes>,
}

impl CheckedSubmission {
    /// Reads and tries a submission.
    pub(super) fn read(
        folder: &std::path::Path,
        season: &SeasonArgs,
        robots: &Robots,
    ) -> Result<CheckedSubmission, CommandError> {
        let read = ReadSubmission::read(folder)?;
        let submission = &read.submission;
        let (track, drawn) = season.track(&submission.track, robots, &submission.robots)?;
        let mut faults = read.faults();
        let mut families: Vec<&str> =
            track.kinds.values().map(|kind| kind.family.as_str()).collect();
        let real = track.track.measured.keys().map(String::as_str);
        if season.measured.is_some() {
            families.extend(real.clone());
        }
        for family in submission.robots.iter().filter(|family| !families.contains(&family.as_str()))
        {
            let needs = if real.clone().any(|name| name == family) {
                "; it is a real robot and needs --measured DIR"
            } else {
                ""
            };
            faults.push(format!(
                "robots: found `{family}`, expected families of the track: {}{needs}",
                unique(&families)
            ));
        }
        if !matches!(track.track.task, Task::Name(_)) {
            faults.extend(engine_faults(&drawn));
        }
        let has_questions = recordings(&track.track.task).is_some();
        match (&submission.policy, &submission.answers, has_questions) {
            (None, _, false) => faults
                .push("policy: found nothing, expected a policy: the track has trials".to_owned()),
            (_, None, true) => faults.push(
                "answers: found nothing, expected a folder of answers: the track has questions"
                    .to_owned(),
            ),
            _ => {}
        }
        let mut times = None;
        if let (true, Some(policy), false) = (faults.is_empty(), &submission.policy, has_questions)
        {
            match tried(policy, &read, &track, &drawn) {
                Ok(found) => times = found,
                Err(found) => faults.extend(found),
            }
        }
        if faults.is_empty() {
            return Ok(CheckedSubmission { read, track, robots: drawn, times });
        }
        Err(CommandError::BadInput(format!(
            "{}:\n  {}",
            folder.join("submission.yaml").display(),
            faults.join("\n  ")
        )))
    }
}

/// Engines that cannot be started on this machine: their robots could not be played.
fn engine_faults(robots: &[LeagueRobot]) -> Vec<String> {
    let external = robots.iter().filter(|robot| matches!(robot.plant, PlantSpec::External(_)));
    let one_each: BTreeMap<&str, &LeagueRobot> =
        external.map(|robot| (robot.engine.as_str(), robot)).collect();
    let failed = |(engine, robot): (&str, &LeagueRobot)| {
        let error = robot.plant.build(STEP_S).err()?;
        Some(format!(
            "this machine: engine `{engine}`: found {error}, expected a robot that can be played; without MuJoCo: `pip install -r benches/league/requirements.txt`"
        ))
    };
    one_each.into_iter().filter_map(failed).collect()
}

/// How a policy runs that plays a track.
fn confined(track: &ReadTrack) -> ProcessOptions {
    ProcessOptions { confined: true, answer_s: track.track.answer_s, ..ProcessOptions::default() }
}

fn unique(names: &[&str]) -> String {
    let names: std::collections::BTreeSet<&str> = names.iter().copied().collect();
    names.into_iter().collect::<Vec<_>>().join(", ")
}

/// Duration of a control step, seconds: the paper's 5 Hz.
const STEP_S: f64 = 0.2;
/// Number of answers whose time is measured on each robot.
const TIMED: usize = 20;

/// Starts the policy for each number of tendons and asks it the same twice.
fn tried(
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
