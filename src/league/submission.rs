//! Submissions: a folder with `submission.yaml` and what it names.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::season::DEVELOPMENT;
use super::{LeagueError, NAME, is_name};
use crate::policies::{self, OnnxOptions, OutsidePolicy, ProgramOptions, PythonOptions};
use crate::runner::Digest;
use crate::specs::{Document, files_behind};

/// Name of the file that describes a submission.
pub const FILE: &str = "submission.yaml";

/// A submission as its file gives it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Submission {
    /// Name on the board: letters, digits, `_` and `-`.
    pub name: String,
    /// Its authors.
    pub authors: Vec<String>,
    /// The track.
    pub track: String,
    /// Families of robots that it plays; empty: all.
    #[serde(default)]
    pub robots: Vec<String>,
    /// The policy, for tracks with trials.
    #[serde(default)]
    pub policy: Option<SubmittedPolicy>,
    /// Folder of the answers, for tracks with questions.
    #[serde(default)]
    pub answers: Option<PathBuf>,
    /// Whose questions they answer, as `spinebench league robots` says.
    #[serde(default = "development")]
    pub questions: String,
    /// What it was trained on, in words.
    pub trained_on: String,
    /// Measured samples of real or league robots that it was trained on beforehand.
    pub real_samples: u64,
    /// Licence of what is submitted.
    pub licence: String,
}

fn development() -> String {
    DEVELOPMENT.to_owned()
}

/// A submitted policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SubmittedPolicy {
    /// A network in an ONNX file.
    Onnx(OnnxOptions),
    /// A class in a file of Python.
    Python(PythonOptions),
    /// A program that answers requests in lines of JSON.
    Program(ProgramOptions),
    /// A policy of this program by its name: the baselines.
    Builtin(String),
}

impl SubmittedPolicy {
    /// The policy from outside with its file in `folder`; none for one of this program.
    pub fn outside(&self, folder: &Path) -> Option<OutsidePolicy> {
        let policy = self.as_written()?;
        let file = folder.join(policy.file());
        let file = std::path::absolute(&file).unwrap_or(file);
        Some(policy.with_file(file))
    }

    /// The policy from outside with its file as the submission names it.
    fn as_written(&self) -> Option<OutsidePolicy> {
        match self {
            SubmittedPolicy::Onnx(options) => Some(OutsidePolicy::Onnx(options.clone())),
            SubmittedPolicy::Python(options) => Some(OutsidePolicy::Python(options.clone())),
            SubmittedPolicy::Program(options) => Some(OutsidePolicy::Program(options.clone())),
            SubmittedPolicy::Builtin(_) => None,
        }
    }

    /// Its kind in tables.
    pub fn kind(&self) -> &'static str {
        match self {
            SubmittedPolicy::Onnx(_) => "onnx",
            SubmittedPolicy::Python(_) => "python",
            SubmittedPolicy::Program(_) => "program",
            SubmittedPolicy::Builtin(_) => "builtin",
        }
    }
}

/// A submission with its folder.
#[derive(Clone, Debug)]
pub struct ReadSubmission {
    /// The folder.
    pub folder: PathBuf,
    /// The content of its file.
    pub submission: Submission,
}

impl ReadSubmission {
    /// Reads the file of a submission.
    ///
    /// # Errors
    /// [`LeagueError::Input`] for a missing file, and for the first wrong key.
    pub fn read(folder: &Path) -> Result<ReadSubmission, LeagueError> {
        let document = Document::read(&folder.join(FILE), &[], &[]).map_err(LeagueError::input)?;
        let submission = document.parse().map_err(LeagueError::input)?;
        Ok(ReadSubmission { folder: folder.to_owned(), submission })
    }

    /// What is wrong with it apart from its track: each fault as `key: found …, expected …`.
    pub fn faults(&self) -> Vec<String> {
        let Submission { name, authors, licence, trained_on, policy, answers, .. } =
            &self.submission;
        let mut faults = Vec::new();
        let taken = matches!(policy, Some(SubmittedPolicy::Builtin(builtin)) if builtin == name);
        if !is_name(name) || policies::find(name).is_some() && !taken {
            faults.push(format!(
                "name: found `{name}`, expected {NAME}, and no name of a policy of this program"
            ));
        }
        let behind = files_behind(&self.folder.join(FILE));
        for extended in behind.iter().filter(|file| !self.is_within(file)) {
            faults.push(self.outside_its_folder("extends", extended));
        }
        for (key, missing) in [
            ("authors", authors.iter().all(|author| author.trim().is_empty())),
            ("licence", licence.trim().is_empty()),
            ("trained_on", trained_on.trim().is_empty()),
        ] {
            if missing {
                faults.push(format!("{key}: found nothing, expected a text"));
            }
        }
        if let Some(SubmittedPolicy::Builtin(builtin)) = policy
            && policies::find(builtin).is_none()
        {
            faults.push(format!(
                "policy.builtin: found `{builtin}`, expected a policy of this program"
            ));
        }
        let kind = policy.as_ref().map_or("", SubmittedPolicy::kind);
        let outside = policy.as_ref().and_then(SubmittedPolicy::as_written);
        if let Some(file) = outside.as_ref().map(OutsidePolicy::file) {
            let place = self.folder.join(file);
            if !place.is_file() {
                faults.push(format!("policy.{kind}.file: found no file {}", place.display()));
            } else if !stays_below(file) || !self.is_within(&place) {
                faults.push(self.outside_its_folder(&format!("policy.{kind}.file"), file));
            }
        }
        if let Some(Err(option)) = outside.as_ref().map(OutsidePolicy::check) {
            faults.push(format!("policy.{kind}.{option}"));
        }
        if let Some(answers) = answers {
            let place = self.folder.join(answers);
            if !place.is_dir() {
                faults.push(format!("answers: found no folder {}", place.display()));
            } else if !stays_below(answers) || !self.is_within(&place) {
                faults.push(self.outside_its_folder("answers", answers));
            }
        }
        if let Err(LeagueError::Input(link)) = files(&self.folder) {
            faults.push(link);
        }
        faults
    }

    /// Whether the digest of the submission covers a file: it lies in its folder, without links.
    fn is_within(&self, file: &Path) -> bool {
        let (Ok(file), Ok(folder)) = (file.canonicalize(), self.folder.canonicalize()) else {
            return false;
        };
        file.strip_prefix(&folder).is_ok_and(|below| !is_written(below))
    }

    fn outside_its_folder(&self, key: &str, found: &Path) -> String {
        let (found, folder) = (found.display(), self.folder.display());
        format!("{key}: found {found}, expected a place in the folder of the submission, {folder}")
    }

    /// A copy of the files that the digest covers: nothing else can serve the policy.
    ///
    /// # Errors
    /// [`LeagueError::Failed`] for a file that cannot be copied.
    pub fn copied(&self, folder: &Path) -> Result<ReadSubmission, LeagueError> {
        for file in files(&self.folder)? {
            let (from, to) = (self.folder.join(&file), folder.join(&file));
            let made = std::fs::create_dir_all(to.parent().unwrap_or(folder));
            made.and_then(|()| std::fs::copy(&from, &to))
                .map_err(|error| LeagueError::failed(format!("{}: {error}", from.display())))?;
        }
        Ok(ReadSubmission { folder: folder.to_owned(), submission: self.submission.clone() })
    }

    /// Digest of all its files, in the order of their names, but for what a score has written.
    ///
    /// # Errors
    /// [`LeagueError::Input`] for a file that cannot be read.
    pub fn digest(&self) -> Result<Digest, LeagueError> {
        let mut bytes = Vec::new();
        for file in files(&self.folder)? {
            let content = std::fs::read(self.folder.join(&file))
                .map_err(|error| LeagueError::input(format!("{}: {error}", file.display())))?;
            bytes.extend(file.display().to_string().bytes());
            bytes.extend(Digest::of(&content).bytes());
        }
        Ok(Digest::of(&bytes))
    }
}

/// Folder that `score` writes below that of a submission; it is no part of it.
pub const SCORE_FOLDER: &str = "score";

/// Whether a place below the folder of a submission is written by a score or by Python.
fn is_written(below: &Path) -> bool {
    below.starts_with(SCORE_FOLDER) || below.iter().any(|name| name == "__pycache__")
}

/// Whether a place in a submission is named from its folder downwards.
fn stays_below(place: &Path) -> bool {
    place.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

/// The files of a folder and those below it, sorted.
fn files(folder: &Path) -> Result<Vec<PathBuf>, LeagueError> {
    let mut found = Vec::new();
    let mut pending = vec![PathBuf::new()];
    while let Some(below) = pending.pop() {
        let place = folder.join(&below);
        let entries = std::fs::read_dir(&place)
            .map_err(|error| LeagueError::input(format!("{}: {error}", place.display())))?;
        for entry in entries.flatten() {
            let name = below.join(entry.file_name());
            match entry.file_type() {
                Ok(kind) if kind.is_dir() && !is_written(&name) => pending.push(name),
                Ok(kind) if kind.is_file() => found.push(name),
                Ok(kind) if !kind.is_dir() => {
                    let file = folder.join(&name).display().to_string();
                    let found =
                        if kind.is_symlink() { "a link" } else { "a pipe, socket or device" };
                    return Err(LeagueError::input(format!(
                        "{file}: found {found}, expected a file: a digest covers the submission"
                    )));
                }
                _ => {}
            }
        }
    }
    found.sort();
    Ok(found)
}
