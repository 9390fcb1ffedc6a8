//! Files that hold one trial each: which of those on a command line they are, and which trial each
//! holds.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fs::read_dir;
use std::path::{Path, PathBuf};

use super::commands::trial_numbers;
use super::map::TrialFilesMap;
use crate::data::DataError;

/// What stands for the trial in the name of a file.
pub(crate) const TRIAL: &str = "{trial}";

/// The files that a command line names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogFiles {
    /// The files; those of a folder or of a name with `*` or `?` in natural order (2 before 10).
    pub files: Vec<PathBuf>,
    /// Whether a folder was named.
    pub from_folder: bool,
}

impl LogFiles {
    /// Finds the files: a folder stands for all files in it, `*` and `?` in the last part of a name
    /// stand for characters.
    ///
    /// # Errors
    /// [`DataError`] for a folder that cannot be read or is empty, and a name that no file has.
    pub fn find(named: &[PathBuf]) -> Result<LogFiles, DataError> {
        let mut logs = LogFiles::default();
        for path in named {
            if path.is_dir() {
                logs.from_folder = true;
                logs.files.extend(listed(path, path, &|name| !name.starts_with('.'))?);
                continue;
            }
            let name = path
                .file_name()
                .map(|name| name.to_string_lossy().into_owned())
                .unwrap_or_default();
            if path.exists() || !name.contains(['*', '?']) {
                logs.files.push(path.clone());
                continue;
            }
            let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
            let pattern = FilePattern::parse(&name);
            let fits = |file: &str| pattern.trial(file).is_some();
            logs.files.extend(
                listed(path, parent.unwrap_or(Path::new(".")), &fits)?.into_iter().map(|file| {
                    // As it was written: without `./`.
                    if parent.is_none() {
                        file.strip_prefix(".").map(Path::to_owned).unwrap_or(file)
                    } else {
                        file
                    }
                }),
            );
        }
        Ok(logs)
    }
}

/// Files of a folder whose names fit, in natural order.
fn listed(
    named: &Path,
    folder: &Path,
    fits: &dyn Fn(&str) -> bool,
) -> Result<Vec<PathBuf>, DataError> {
    let failed = |error: std::io::Error| DataError::Read {
        file: named.to_owned(),
        reason: error.to_string(),
    };
    let mut files = Vec::new();
    for entry in read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name =
            path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if path.is_file() && fits(&name) {
            files.push((name, path));
        }
    }
    if files.is_empty() {
        let expected = "at least one file";
        return Err(DataError::Empty { file: named.to_owned(), found: "no such files", expected });
    }
    files.sort_by(|(a, _), (b, _)| natural(a, b));
    Ok(files.into_iter().map(|(_, path)| path).collect())
}

/// Order of names in which numbers count as numbers.
fn natural(a: &str, b: &str) -> Ordering {
    let parts = |text: &str| -> Vec<(bool, u64, String)> {
        let mut parts: Vec<String> = Vec::new();
        for character in text.chars() {
            let is_digit = character.is_ascii_digit();
            match parts.last_mut() {
                Some(part) if part.ends_with(|last: char| last.is_ascii_digit()) == is_digit => {
                    part.push(character)
                }
                _ => parts.push(character.to_string()),
            }
        }
        let part = |part: String| match part.parse() {
            Ok(number) => (false, number, part),
            Err(_) => (true, 0, part),
        };
        parts.into_iter().map(part).collect()
    };
    parts(a).cmp(&parts(b))
}

/// Part of the pattern of a file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PatternPart {
    Character(char),
    One,
    Any,
    Trial,
}

/// Pattern of the names of files.
#[derive(Clone, Debug)]
struct FilePattern {
    parts: Vec<PatternPart>,
}

impl FilePattern {
    fn parse(text: &str) -> FilePattern {
        let mut parts = Vec::new();
        for (place, piece) in text.split(TRIAL).enumerate() {
            if place > 0 {
                parts.push(PatternPart::Trial);
            }
            parts.extend(piece.chars().map(|character| match character {
                '*' => PatternPart::Any,
                '?' => PatternPart::One,
                other => PatternPart::Character(other),
            }));
        }
        FilePattern { parts }
    }

    /// Characters that are given: the pattern with more of them is the more exact one.
    fn literal_length(&self) -> usize {
        self.parts.iter().filter(|part| matches!(part, PatternPart::Character(_))).count()
    }

    /// The trial in a name that fits, as short as possible; empty for a pattern without one.
    fn trial(&self, name: &str) -> Option<String> {
        let characters: Vec<char> = name.chars().collect();
        let mut trial = None;
        fits(&self.parts, &characters, &mut trial).then(|| trial.unwrap_or_default())
    }
}

fn fits(parts: &[PatternPart], name: &[char], trial: &mut Option<String>) -> bool {
    let Some((part, rest)) = parts.split_first() else { return name.is_empty() };
    match part {
        PatternPart::Character(character) => {
            name.first() == Some(character) && fits(rest, &name[1..], trial)
        }
        PatternPart::One => !name.is_empty() && fits(rest, &name[1..], trial),
        PatternPart::Any => (0..=name.len()).any(|length| fits(rest, &name[length..], trial)),
        PatternPart::Trial => (1..=name.len()).any(|length| {
            let fitting = fits(rest, &name[length..], trial);
            if fitting {
                *trial = Some(name[..length].iter().collect());
            }
            fitting
        }),
    }
}

/// Files of one trial.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TrialFiles {
    /// Number in the recording.
    pub(crate) number: u64,
    /// What stands in the file's name.
    pub(crate) name: String,
    /// File of the commands.
    pub(crate) commands: PathBuf,
    /// File of the tracking, where it is another.
    pub(crate) tracking: Option<PathBuf>,
}

/// The trials that files hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FoundTrials {
    /// In the order of their numbers.
    pub(crate) trials: Vec<TrialFiles>,
    /// Whether trials have names that are no numbers.
    pub(crate) named: bool,
    /// Files whose names fit no pattern.
    pub(crate) passed_over: Vec<PathBuf>,
}

impl FoundTrials {
    /// Sorts files into trials.
    ///
    /// # Errors
    /// [`DataError`] when no file fits, when two have the same trial, and when one of the two files
    /// of a trial is missing.
    pub(crate) fn among(files: &[PathBuf], map: &TrialFilesMap) -> Result<FoundTrials, DataError> {
        let patterns: Vec<(&String, FilePattern)> = [Some(&map.commands), map.tracking.as_ref()]
            .into_iter()
            .flatten()
            .map(|text| (text, FilePattern::parse(text)))
            .collect();
        let SortedFiles { of_kind, passed_over } = sorted(files, &patterns)?;
        let Some((first, tracking)) = of_kind.split_first() else {
            return Err(none_fits(files, map));
        };
        if first.is_empty() {
            return Err(none_fits(files, map));
        }
        for (trial, file) in tracking.iter().flatten() {
            if !first.contains_key(trial) {
                let expected =
                    format!("a file `{}` with its commands", map.commands.replace(TRIAL, trial));
                return Err(refused(
                    file,
                    format!("only the tracking of trial `{trial}`"),
                    expected,
                ));
            }
        }
        let mut names: Vec<&String> = first.keys().collect();
        names.sort_by(|a, b| natural(a, b));
        let numbers = trial_numbers(names.iter().map(|name| name.as_str()));
        let trial = |(place, name): (usize, &&String)| {
            let tracking = match (tracking.first(), patterns.get(1)) {
                (Some(files), Some((pattern, _))) => {
                    Some(files.get(*name).cloned().ok_or_else(|| {
                        let expected =
                            format!("a file `{}` with its tracking", pattern.replace(TRIAL, name));
                        refused(
                            &first[*name],
                            format!("only the commands of trial `{name}`"),
                            expected,
                        )
                    })?)
                }
                _ => None,
            };
            let number = numbers.as_ref().map_or(place as u64, |numbers| numbers[place]);
            Ok(TrialFiles {
                number,
                name: (*name).clone(),
                commands: first[*name].clone(),
                tracking,
            })
        };
        let mut trials =
            names.iter().enumerate().map(trial).collect::<Result<Vec<_>, DataError>>()?;
        trials.sort_by_key(|trial| trial.number);
        Ok(FoundTrials { trials, named: numbers.is_none(), passed_over })
    }
}

/// Files by the pattern that they fit.
struct SortedFiles {
    /// For each pattern the files by trial.
    of_kind: Vec<BTreeMap<String, PathBuf>>,
    passed_over: Vec<PathBuf>,
}

/// Gives each file to the pattern with the longest literal text of those that it fits.
fn sorted(
    files: &[PathBuf],
    patterns: &[(&String, FilePattern)],
) -> Result<SortedFiles, DataError> {
    let mut of_kind: Vec<BTreeMap<String, PathBuf>> = vec![BTreeMap::new(); patterns.len()];
    let mut passed_over = Vec::new();
    for file in files {
        let name =
            file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let fitting = patterns.iter().enumerate().filter_map(|(kind, (_, pattern))| {
            Some((pattern.literal_length(), kind, pattern.trial(&name)?))
        });
        let Some((_, kind, trial)) = fitting.max_by_key(|(length, ..)| *length) else {
            passed_over.push(file.clone());
            continue;
        };
        if let Some(other) = of_kind[kind].insert(trial.clone(), file.clone()) {
            let found = format!("trial `{trial}`, as in {}", other.display());
            return Err(refused(
                file,
                found,
                "one file per trial (`trial_files` of the map)".to_owned(),
            ));
        }
    }
    Ok(SortedFiles { of_kind, passed_over })
}

fn refused(file: &Path, found: String, expected: String) -> DataError {
    DataError::Line { file: file.to_owned(), place: "its name".to_owned(), found, expected }
}

fn none_fits(files: &[PathBuf], map: &TrialFilesMap) -> DataError {
    let file = files.first().cloned().unwrap_or_default();
    let found = format!("no matching name among {} files", files.len());
    refused(
        &file,
        found,
        format!("names like `{}` (`trial_files.commands` of the map)", map.commands),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn among(
        files: &[&str],
        commands: &str,
        tracking: Option<&str>,
    ) -> Result<FoundTrials, String> {
        let map = TrialFilesMap { commands: commands.into(), tracking: tracking.map(Into::into) };
        let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
        FoundTrials::among(&files, &map).map_err(|error| error.to_string())
    }

    fn told(found: &FoundTrials) -> Vec<(u64, &str)> {
        found.trials.iter().map(|trial| (trial.number, trial.name.as_str())).collect()
    }

    #[test]
    fn numbers_and_names_of_trials_stand_in_the_names_of_files() {
        let found =
            among(&["d/run_10_a.csv", "d/run_9_b_c.csv", "d/notes.txt"], "run_{trial}_*.csv", None)
                .unwrap();
        assert_eq!(
            (told(&found), found.named, found.passed_over.len()),
            (vec![(9, "9"), (10, "10")], false, 1)
        );
        let found = among(&["fast10.csv", "slow.csv", "fast9.csv"], "{trial}.csv", None).unwrap();
        assert_eq!(
            (told(&found), found.named),
            (vec![(0, "fast9"), (1, "fast10"), (2, "slow")], true)
        );
        // Two labels of one number are names.
        assert_eq!(told(&among(&["1.csv", "01.csv"], "{trial}.csv", None).unwrap()).len(), 2);
        // The more exact pattern has the file.
        let found =
            among(&["3.csv", "3_mocap.csv"], "{trial}.csv", Some("{trial}_mocap.csv")).unwrap();
        assert_eq!(found.trials[0].tracking.as_deref(), Some(Path::new("3_mocap.csv")));
    }

    #[test]
    fn files_that_do_not_fit_together_are_refused_by_name() {
        let said =
            |files: &[&str], commands, tracking| among(files, commands, tracking).unwrap_err();
        let two = Some("t{trial}.csv");
        assert!(
            said(&["x.csv"], "c{trial}.csv", None)
                .starts_with("x.csv, its name: found no matching name among 1 files")
        );
        assert!(
            said(&["c1a.csv", "c1b.csv"], "c{trial}?.csv", None)
                .contains("c1b.csv, its name: found trial `1`, as in c1a.csv")
        );
        assert!(
            said(&["c1.csv", "c2.csv", "t1.csv"], "c{trial}.csv", two)
                .contains("expected a file `t2.csv` with its tracking")
        );
        assert!(
            said(&["c1.csv", "t1.csv", "t2.csv"], "c{trial}.csv", two)
                .contains("expected a file `c2.csv` with its commands")
        );
    }
}
