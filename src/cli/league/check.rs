//! `spinebench league check`.

use super::common::{Robots, SeasonArgs, engine_faults};
use super::places::{private_folder, refuse_inside};
use super::tried::{confined, tried};
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::league::LeagueError;
use spinebench::league::answers::Answers;
use spinebench::league::board::TickTimes;
use spinebench::league::questions::recordings;
use spinebench::league::robot::LeagueRobot;
use spinebench::league::submission::{FILE, ReadSubmission};
use spinebench::league::track::{ReadTrack, Task};
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
            checked.answers(answers)?;
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
    /// Its folder.
    folder: PathBuf,
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
        if let Some(secret) = &season.secret {
            refuse_inside(folder, "--secret", secret)?;
        }
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
        if !faults.is_empty() {
            return Err(all(folder, &faults));
        }
        let scratch = private_folder("interrupted; nothing was written")?;
        let read = read.copied(&scratch.path().join("submission"))?;
        let times = match &read.submission.policy {
            Some(policy) if !has_questions => {
                tried(policy, &read, &track, &drawn).map_err(|faults| all(folder, &faults))?
            }
            _ => None,
        };
        let folder = folder.to_owned();
        Ok(CheckedSubmission { folder, read, scratch, track, robots: drawn, times })
    }

    /// The answers in a folder of the submission. Errors name the files of the user, not the copy.
    pub(super) fn answers(&self, folder: &Path) -> Result<Answers, CommandError> {
        let copy = self.read.folder.display().to_string();
        let answers = Answers::read(&self.track, &self.robots, &self.read.folder.join(folder));
        answers.map_err(|error| match error {
            LeagueError::Input(words) => {
                CommandError::BadInput(words.replace(&copy, &self.folder.display().to_string()))
            }
            failed => failed.into(),
        })
    }
}

/// The error for all faults of a submission.
fn all(folder: &Path, faults: &[String]) -> CommandError {
    let file = folder.join(FILE);
    CommandError::BadInput(format!("{}:\n  {}", file.display(), faults.join("\n  ")))
}

fn unique(names: &[&str]) -> String {
    let names: std::collections::BTreeSet<&str> = names.iter().copied().collect();
    names.into_iter().collect::<Vec<_>>().join(", ")
}
