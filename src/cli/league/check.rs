//! `spinebench league check`.

use super::common::{Robots, SeasonArgs};
use super::tried::{STEP_S, confined, tried};
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::league::answers::Answers;
use spinebench::league::board::TickTimes;
use spinebench::league::questions::recordings;
use spinebench::league::robot::LeagueRobot;
use spinebench::league::submission::{FILE, ReadSubmission};
use spinebench::league::track::{ReadTrack, Task};
use spinebench::plants::PlantSpec;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

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
            Answers::read(&checked.track, &checked.robots, &self.folder.join(answers))?;
        }
        let times =
            checked.times.map(|times| format!(", {:.1} ms an answer", 1e3 * times.median_s));
        let submission = &checked.read.submission;
        let policy = submission.policy.as_ref();
        let mut outside = policy.and_then(|policy| policy.outside(&checked.read.folder));
        if let Some(outside) = &mut outside {
            let tendons = checked.robots.first().map_or(1, |robot| robot.plant.tendons());
            outside.read_attributes(tendons, &confined(&checked.track));
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
    /// A copy of what its digest covers, in `scratch`.
    pub(super) read: ReadSubmission,
    pub(super) scratch: TempDir,
    pub(super) track: ReadTrack,
    pub(super) robots: Vec<LeagueRobot>,
    pub(super) times: Option<TickTimes>,
}

impl CheckedSubmission {
    /// Reads and tries a submission.
    pub(super) fn read(
        folder: &Path,
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
            (_, Some(_), true) if submission.questions != robots.label() => faults.push(format!(
                "questions: found `{}`, expected `{}`, whose robots play",
                submission.questions,
                robots.label()
            )),
            _ => {}
        }
        let mut times = None;
        if !faults.is_empty() {
            return Err(all(folder, &faults));
        }
        let scratch = private_folder().map_err(CommandError::failed)?;
        let read = read.copied(&scratch.path().join("submission"))?;
        if let (Some(policy), false) = (&read.submission.policy, has_questions) {
            match tried(policy, &read, &track, &drawn) {
                Ok(found) => times = found,
                Err(found) => faults.extend(found),
            }
        }
        if faults.is_empty() {
            return Ok(CheckedSubmission { read, scratch, track, robots: drawn, times });
        }
        Err(all(folder, &faults))
    }
}

/// The error for all faults of a submission.
fn all(folder: &Path, faults: &[String]) -> CommandError {
    let file = folder.join(FILE);
    CommandError::BadInput(format!("{}:\n  {}", file.display(), faults.join("\n  ")))
}

/// A folder that no other user can read: it holds experiments with the hidden effects.
fn private_folder() -> std::io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
    builder.prefix("spinebench-league-").tempdir()
}

/// Engines that cannot be started on this machine: their robots could not be played.
pub(super) fn engine_faults(robots: &[LeagueRobot]) -> Vec<String> {
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

fn unique(names: &[&str]) -> String {
    let names: std::collections::BTreeSet<&str> = names.iter().copied().collect();
    names.into_iter().collect::<Vec<_>>().join(", ")
}
