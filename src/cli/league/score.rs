//! `spinebench league score`.

use super::check::CheckedSubmission;
use super::common::{Robots, SeasonArgs};
use super::places::{real_place, refuse_inside};
use crate::cli::program::shared::{CacheArgs, ThreadArgs};
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::data::write_atomic;
use spinebench::league::board::{SCORE, TIMING, board};
use spinebench::league::instance::{Player, robot_samples};
use spinebench::league::play::{PlayOptions, add_floors, play};
use spinebench::league::score::{
    Digests, FORMAT, Machine, RobotScore, Score, ScorePart, failure_words, failures,
};
use spinebench::league::season::digest;
use spinebench::league::submission::{SCORE_FOLDER, SubmittedPolicy};
use spinebench::league::track::Task;
use spinebench::report::league;
use spinebench::rows::league::{ANSWERS, SHARE_NOT_NAMED};
use spinebench::runner::{Digest, Progress, Store, processor};
use std::path::{Path, PathBuf};

/// Score a submission on the robots of its track: its policy runs in a process of its own, without
/// network and files, within limits of time and memory. Writes score.json (the same bytes for the
/// same submission), times, tables and a figure.
#[derive(Args)]
pub(crate) struct ScoreCommand {
    /// Folder of the submission, with `submission.yaml`.
    folder: PathBuf,
    /// Folder to write the score in [default: `score` in that of the submission].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    season: SeasonArgs,
    #[command(flatten)]
    cache: CacheArgs,
    #[command(flatten)]
    threads: ThreadArgs,
}

impl ScoreCommand {
    pub(crate) fn execute(&self, progress: &Progress) -> CommandResult {
        let robots = self.season.robots()?;
        let out = self.out.clone().unwrap_or_else(|| self.folder.join(SCORE_FOLDER));
        if real_place(&out) != real_place(&self.folder.join(SCORE_FOLDER)) {
            refuse_inside(&self.folder, "--out", &out)?;
        }
        let checked = CheckedSubmission::read(&self.folder, &self.season, &robots)?;
        std::fs::create_dir_all(&out).map_err(|error| {
            CommandError::BadInput(format!("--out: {}: {error}", out.display()))
        })?;
        let digest = digest(&self.season.tracks)?.to_string();
        let scores = self.robot_scores(&checked, progress)?;
        let score = self.score(&checked, &robots, digest, scores)?;
        let write = |name: &str, text: &str| {
            write_atomic(&out.join(name), text.as_bytes()).map_err(CommandError::failed)
        };
        write(SCORE, &score.json())?;
        if let Some(times) = &checked.times {
            write(TIMING, &(serde_json::to_string_pretty(times).unwrap_or_default() + "\n"))?;
        }
        for artifact in league::board(&board(&out)?).map_err(CommandError::failed)? {
            write_atomic(&out.join(named(&artifact.name)), &artifact.bytes)
                .map_err(CommandError::failed)?;
        }
        tell(&score, &out);
        Ok(())
    }

    fn robot_scores(
        &self,
        checked: &CheckedSubmission,
        progress: &Progress,
    ) -> Result<Vec<RobotScore>, CommandError> {
        let CheckedSubmission { read, track, robots, .. } = checked;
        let scratch = checked.scratch.path();
        let submission = &read.submission;
        let Some(policy) = submission
            .policy
            .as_ref()
            .filter(|_| matches!(track.track.task, Task::Reach { .. } | Task::Laps { .. }))
        else {
            let answers = submission.answers.clone().unwrap_or_default();
            return Ok(checked.answers(&answers)?.judge(robots)?);
        };
        let (player, name) = match (policy.outside(&read.folder), policy) {
            (Some(policy), _) => {
                (Player::Submitted { name: submission.name.clone(), policy }, &submission.name)
            }
            (None, SubmittedPolicy::Builtin(name)) => (Player::Builtin(vec![name.clone()]), name),
            (None, _) => return Err(CommandError::Failed("a policy without a file".to_owned())),
        };
        // A stored result would hide a policy that decides otherwise the second time.
        let (kept, fresh) = (self.cache.store(), Store::at(scratch.join("store")));
        let store = if matches!(player, Player::Builtin(_)) { &kept } else { &fresh };
        let folders = [scratch.join("trials"), scratch.join("floor")];
        let options =
            |store, specs| PlayOptions { store, threads: self.threads.jobs, progress, specs };
        let mut scores = play(track, robots, &player, &options(store, &folders[0]))?
            .remove(name)
            .unwrap_or_default();
        add_floors(&mut scores, track, robots, &options(&kept, &folders[1]))?;
        Ok(scores)
    }

    fn score(
        &self,
        checked: &CheckedSubmission,
        season: &Robots,
        tracks: String,
        robots: Vec<RobotScore>,
    ) -> Result<Score, CommandError> {
        let CheckedSubmission { read, track, robots: drawn, .. } = checked;
        let submission = &read.submission;
        let policy = submission.policy.as_ref();
        let outside = policy.and_then(|policy| policy.outside(&read.folder));
        let drawn: Vec<String> = drawn
            .iter()
            .map(|robot| {
                format!("{} {:?} {:?} {:?}", robot.name, robot.seed, robot.plant, robot.change)
            })
            .collect();
        let guards = match &outside {
            Some(_) => super::confine::guards().map_err(CommandError::BadInput)?,
            None => String::new(),
        };
        Ok(Score {
            format: FORMAT,
            name: submission.name.clone(),
            authors: submission.authors.clone(),
            track: track.name.clone(),
            measure: if matches!(track.track.task, Task::Name(_)) {
                SHARE_NOT_NAMED
            } else {
                "error over length"
            }
            .to_owned(),
            kind: policy.map_or("answers", SubmittedPolicy::kind).to_owned(),
            trained_on: submission.trained_on.clone(),
            licence: submission.licence.clone(),
            real_samples: submission.real_samples,
            robot_samples: match (policy, outside) {
                (Some(SubmittedPolicy::Builtin(name)), _) => {
                    robot_samples(&track.track, name) as u64
                }
                (_, outside) => outside.map_or(0, |outside| outside.samples() as u64),
            },
            season: season.season.clone(),
            sealed: season.are_sealed(),
            digests: Digests {
                submission: read.digest()?.to_string(),
                tracks,
                robots: Digest::of(drawn.join("\n").as_bytes()).to_string(),
                program: spinebench::VERSION.to_owned(),
                secret: season.secret.clone(),
            },
            machine: Machine {
                system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
                processor: processor(),
                guards,
            },
            robots,
        })
    }
}

/// The name of a file of a single score: that of a board, as a score.
fn named(file: &str) -> String {
    file.replacen("board", "score_table", 1)
}

fn tell(score: &Score, out: &Path) {
    for robot in &score.robots {
        let failures = failures(&robot.cells);
        let words = match (score.measure == SHARE_NOT_NAMED, failures.is_empty()) {
            (true, true) => "named".to_owned(),
            (true, false) => format!("not named: {}", failures.into_keys().collect::<String>()),
            (false, true) => format!("{:6.2} %", 100.0 * robot.error()),
            (false, false) => {
                format!("{:6.2} %, failed: {}", 100.0 * robot.error(), failure_words(&failures))
            }
        };
        println!("{:24} {words}", robot.robot);
    }
    if let Some(summary) = score.summary(ScorePart::default()) {
        let interval = summary
            .interval_95
            .map(|[low, high]| format!(" [{:.2}, {:.2}]", 100.0 * low, 100.0 * high));
        let floor = summary.floor.map(|floor| format!(", floor {:.2} %", 100.0 * floor));
        let cells = score.cells().into_iter().filter(|cell| *cell != ANSWERS);
        let cells: Vec<&str> = cells.collect();
        let of = if cells.is_empty() { String::new() } else { format!(" ({})", cells.join(", ")) };
        println!(
            "{}{of}: {} {:.2} %{}{}",
            score.name,
            score.measure,
            100.0 * summary.error,
            interval.unwrap_or_default(),
            floor.unwrap_or_default()
        );
    }
    println!("{}", out.join(SCORE).display());
}
