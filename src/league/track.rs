//! Tracks: what a league asks, each a file under `experiments/league/`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{LeagueError, NAME, is_name};
use crate::base::BadOption;
use crate::benchmark::Population;
use crate::effects::card;
use crate::policies::{self, ProcessOptions};
use crate::specs::Document;

/// A track as its file gives it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeagueTrack {
    /// What is asked, in a sentence.
    pub about: String,
    /// The task.
    pub task: Task,
    /// File of the robots, relative to that of the track.
    pub robots: PathBuf,
    /// Robots of each kind, each with hidden effects of its own.
    pub robots_each: u64,
    /// What is hidden in a robot.
    pub hidden: Population,
    /// Standard deviation of the tracking noise per axis, metres.
    pub noise_m: f64,
    /// Data budget: most samples of a robot that a policy may take before its trials.
    #[serde(default)]
    pub samples: usize,
    /// Time limit: seconds for each answer of a policy.
    #[serde(default = "answer_s")]
    pub answer_s: f64,
    /// Controllers of this program that know the hidden effects and see the tip without noise. The
    /// best of them on each robot is its floor.
    #[serde(default)]
    pub floor: Vec<String>,
    /// Real robots by name, which were recorded at rest; they play where their recordings are.
    #[serde(default)]
    pub measured: BTreeMap<String, MeasuredRobot>,
    /// Keys of the experiment on each robot, as in any spec.
    #[serde(default)]
    pub experiment: serde_json::Map<String, serde_json::Value>,
}

fn answer_s() -> f64 {
    1.0
}

impl LeagueTrack {
    /// What is hidden in its robots, by key: from the beginning, and from a change on.
    fn hidden_effects(&self) -> Vec<(&'static str, &Population)> {
        let mut hidden = vec![("hidden", &self.hidden)];
        if let Task::Laps { change: Some(change), .. } = &self.task {
            hidden.push(("task.laps.change.effects", &change.effects));
        }
        hidden
    }

    /// Checks every range.
    fn check(&self) -> Result<(), BadOption> {
        BadOption::unless_within("robots_each", self.robots_each, 1..=1000, "1 to 1000")?;
        BadOption::unless_not_negative("noise_m", self.noise_m)?;
        let process = ProcessOptions { answer_s: self.answer_s, ..ProcessOptions::default() };
        process.check()?;
        if let Some(unknown) = self.floor.iter().find(|name| policies::find(name).is_none()) {
            return BadOption::unless(false, "floor", unknown, "policies of this program");
        }
        match &self.task {
            Task::Reach { modes } => {
                let is_new = |place: usize| !modes[..place].contains(&modes[place]);
                let is_good = !modes.is_empty() && (0..modes.len()).all(is_new);
                BadOption::unless(is_good, "modes", modes.join(", "), "different modes")
            }
            Task::Laps { lap_s, speeds, change } => {
                BadOption::unless_positive("lap_s", *lap_s)?;
                BadOption::unless_counted("speeds", speeds.len())?;
                speeds.iter().try_for_each(|speed| BadOption::unless_positive("speeds", *speed))?;
                let between_s = change.as_ref().map_or([0.0; 2], |change| change.between_s);
                BadOption::unless_all_finite("between_s", &between_s)?;
                let is_good = 0.0 <= between_s[0] && between_s[0] <= between_s[1];
                let expected = "two times from 0 s on, the earlier one first";
                BadOption::unless(is_good, "between_s", format!("{between_s:?}"), expected)
            }
            Task::Identify(plan) | Task::Name(plan) => plan.check(),
        }
    }
}

/// The task of a track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Task {
    /// Bring the tip from home to targets.
    Reach {
        /// Modes of the experiment.
        modes: Vec<String>,
    },
    /// Follow a path in time.
    Laps {
        /// Duration of a lap at speed 1, seconds.
        lap_s: f64,
        /// Speeds as multiples of that.
        speeds: Vec<f64>,
        /// The robot changes in each lap, at a time that is drawn between these two, seconds.
        #[serde(default)]
        change: Option<HiddenChange>,
    },
    /// Predict the tips of commands that were not seen, from recordings.
    Identify(QuestionPlan),
    /// Name the effect that the model lacks, from a recording.
    Name(QuestionPlan),
}

/// An unannounced change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HiddenChange {
    /// Earliest and latest time in a trial, seconds.
    pub between_s: [f64; 2],
    /// The effects that the robot gets.
    pub effects: Population,
}

/// Recordings of a robot: random walks from home.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QuestionPlan {
    /// Trials that are given.
    pub trials: usize,
    /// Trials whose tips are asked for.
    #[serde(default)]
    pub asked: usize,
    /// Rows of each trial, one a control step.
    pub rows: usize,
    /// Duration of a control step, seconds.
    pub step_s: f64,
    /// Largest change of a tendon in a step, as a share of the suited travel.
    pub step_share: f64,
    /// Largest pull, as a share of the suited travel.
    pub pull_share: f64,
}

impl QuestionPlan {
    fn check(&self) -> Result<(), BadOption> {
        let expected = "1 to 1000";
        BadOption::unless_within("trials", self.trials, 1..=1000, expected)?;
        BadOption::unless_within("asked", self.asked, ..=1000, "0 to 1000")?;
        BadOption::unless_within("rows", self.rows, 2..=100_000, "2 to 100000")?;
        BadOption::unless_within("step_s", self.step_s, 1e-3..=10.0, "0.001 to 10 s")?;
        BadOption::unless_share("step_share", self.step_share)?;
        BadOption::unless_share("pull_share", self.pull_share)
    }
}

/// A real robot that was recorded: each row is a pose at rest. Its rows are not part of a checkout.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredRobot {
    /// Its recording.
    pub recording: PinnedFile,
    /// The nominal model, which no asked row has changed.
    pub model: PinnedFile,
    /// Patterns of the rows that are asked, with any number of `*`; all other rows are given.
    pub asked: Vec<String>,
    /// Tracked point that is the tip; default: the tip of the recording.
    #[serde(default)]
    pub tip: Option<String>,
}

/// A file whose content everybody has to have.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PinnedFile {
    /// Its name in the folder of the recordings.
    pub file: PathBuf,
    /// BLAKE3 digest of its content, in hexadecimal.
    pub digest: String,
}

/// A kind of robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotKind {
    /// Robots of one family have the same model; a submission may play some families alone.
    pub family: String,
    /// The nominal model, relative to the file of the robots.
    pub model: PathBuf,
    /// Effects of the catalogue that can be hidden in it; empty: all. An effect that changes nothing
    /// of this robot could not be named.
    #[serde(default)]
    pub effects: Vec<String>,
    /// Weight that the mode `closed_load` hangs on the tip, kilograms.
    pub load_kg: f64,
    /// The engine that plays it; the rod of this program where there is none.
    #[serde(default)]
    pub engine: Option<Engine>,
}

/// Another engine than the rod, behind the protocol of an `external` plant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Engine {
    /// Name in tables.
    pub name: String,
    /// Program and arguments; files are relative to the file of the robots.
    pub command: Vec<String>,
    /// What it is told.
    #[serde(default)]
    pub options: serde_json::Map<String, serde_json::Value>,
    /// Files beside the command that the robot depends on.
    #[serde(default)]
    pub files: Vec<PathBuf>,
}

/// Kinds of robots by name.
pub type RobotKinds = BTreeMap<String, RobotKind>;

/// A track with its robots, and where they were read.
#[derive(Clone, Debug)]
pub struct ReadTrack {
    /// Name: that of its file.
    pub name: String,
    /// The file.
    pub file: PathBuf,
    /// Its content.
    pub track: LeagueTrack,
    /// Folder of the file of the robots.
    pub robots_folder: PathBuf,
    /// The robots.
    pub kinds: RobotKinds,
}

impl ReadTrack {
    /// Reads and checks the track called `name` in a folder of tracks.
    ///
    /// # Errors
    /// [`LeagueError::Input`] for an unknown name, and for the first wrong key.
    pub fn read(folder: &Path, name: &str) -> Result<ReadTrack, LeagueError> {
        let file = folder.join(format!("{name}.yaml"));
        let tracks = names(folder)?;
        if !tracks.iter().any(|track| track == name) {
            let (folder, tracks) = (folder.display(), tracks.join("`, `"));
            return Err(LeagueError::input(format!(
                "track: found `{name}`, expected one of the tracks in {folder}: `{tracks}`"
            )));
        }
        let document = Document::read(&file, &[], &[]).map_err(LeagueError::input)?;
        let track: LeagueTrack = document.parse().map_err(LeagueError::input)?;
        let wrong = |words: String| LeagueError::input(format!("{}: {words}", file.display()));
        track.check().map_err(|error| wrong(error.to_string()))?;
        for (key, population) in track.hidden_effects() {
            population.check().map_err(|error| wrong(format!("{key}.{error}")))?;
        }
        if !track.measured.is_empty() && !matches!(track.task, Task::Identify(_)) {
            let words =
                "measured: found recorded robots, expected none: the task is not `identify`";
            return Err(wrong(words.to_owned()));
        }
        let robots = folder.join(&track.robots);
        let document = Document::read(&robots, &[], &[]).map_err(LeagueError::input)?;
        let kinds: RobotKinds = document.parse().map_err(LeagueError::input)?;
        check_kinds(&kinds, &track)
            .map_err(|words| LeagueError::input(format!("{}: {words}", robots.display())))?;
        let robots_folder = robots.parent().unwrap_or(Path::new("")).to_owned();
        Ok(ReadTrack { name: name.to_owned(), file, track, robots_folder, kinds })
    }

    /// The spec that the experiment extends.
    pub fn extended(&self) -> Option<PathBuf> {
        let extended = self.track.experiment.get("extends")?.as_str()?;
        let file = self.file.parent().unwrap_or(Path::new("")).join(extended);
        Some(std::path::absolute(&file).unwrap_or(file))
    }
}

/// Refuses robots without a name, and those in which nothing of what the track hides can be hidden.
fn check_kinds(kinds: &RobotKinds, track: &LeagueTrack) -> Result<(), String> {
    if kinds.is_empty() && track.measured.is_empty() {
        return Err("found no robots, expected some".to_owned());
    }
    for (name, kind) in kinds {
        for (key, name) in [("", name), (".family", &kind.family)] {
            if !is_name(name) {
                return Err(format!("{name}{key}: found `{name}`, expected {NAME}"));
            }
        }
        BadOption::unless_not_negative("load_kg", kind.load_kg)
            .map_err(|error| format!("{name}.{error}"))?;
        if let Some(unknown) = kind.effects.iter().find(|effect| card(effect).is_none()) {
            return Err(format!(
                "{name}.effects: found `{unknown}`, expected names of `spinebench effects`"
            ));
        }
        for (key, Population { effects, .. }) in track.hidden_effects() {
            let is_hidden = |effect: &String| effects.is_empty() || effects.contains(effect);
            if !kind.effects.is_empty() && !kind.effects.iter().any(is_hidden) {
                return Err(format!(
                    "{name}.effects: found none of `{key}` of the track, expected one of {}",
                    effects.join(", ")
                ));
            }
        }
    }
    Ok(())
}

/// Names of the tracks in a folder: its YAML files that have a task.
///
/// # Errors
/// [`LeagueError::Input`] where the folder cannot be read.
pub fn names(folder: &Path) -> Result<Vec<String>, LeagueError> {
    let words = |error| {
        format!(
            "{}: found {error}, expected a folder of tracks (`experiments/league` of a checkout), or --tracks DIR",
            folder.display()
        )
    };
    let entries = std::fs::read_dir(folder).map_err(|error| LeagueError::input(words(error)))?;
    let mut names: Vec<String> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|end| end == "yaml") && path.is_file())
        .filter(|path| std::fs::read_to_string(path).is_ok_and(|text| text.contains("\ntask:")))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    names.sort();
    Ok(names)
}
