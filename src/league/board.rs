//! The board: scores of many submissions, ranked where their intervals do not overlap.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::LeagueError;
use super::robot::MEASURED;
use super::score::{RobotPart, Score, ScorePart, failure_words};
use super::season::label;
use crate::rows::league::{ALL, BoardRow};

/// Times of the answers of a policy (`timing.json`): they differ from run to run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickTimes {
    /// Median, seconds.
    pub median_s: f64,
    /// 95th percentile, seconds.
    pub p95_s: f64,
}

/// A score, with the times of its policy where it has one of its own.
type TimedScore = (Score, Option<TickTimes>);

/// Name of the file of a score, and of the times beside it.
pub const SCORE: &str = "score.json";
/// See [`SCORE`].
pub const TIMING: &str = "timing.json";

/// The rows of the scores in a folder and those below it.
///
/// # Errors
/// [`LeagueError::Input`] for a file that is no score, and where there is none.
pub fn board(folder: &Path) -> Result<Vec<BoardRow>, LeagueError> {
    let mut files = Vec::new();
    collect(folder, &mut files)?;
    files.sort();
    if files.is_empty() {
        return Err(LeagueError::input(format!(
            "{}: found no {SCORE} in it, expected scores of `spinebench league score`",
            folder.display()
        )));
    }
    let mut scores = Vec::new();
    for file in &files {
        let timing = std::fs::read_to_string(file.with_file_name(TIMING)).ok();
        let times: Option<TickTimes> = timing.and_then(|text| serde_json::from_str(&text).ok());
        scores.push((Score::read(file)?, times));
    }
    let mut groups: BTreeMap<(&str, String), Vec<(&Path, &TimedScore)>> = BTreeMap::new();
    for (file, score) in files.iter().zip(&scores) {
        groups.entry((&score.0.track, season(&score.0))).or_default().push((file, score));
    }
    let mut rows = Vec::new();
    for group in groups.values() {
        check_comparable(group)?;
        rows.extend(of_track(&group.iter().map(|(_, score)| *score).collect::<Vec<_>>()));
    }
    Ok(rows)
}

/// The season of a score, and whether its robots were the sealed ones.
fn season(score: &Score) -> String {
    label(&score.season, score.sealed)
}

/// Refuses two scores of one name, and scores on other tracks, models, engines or sealed robots than
/// the first.
fn check_comparable(group: &[(&Path, &TimedScore)]) -> Result<(), LeagueError> {
    for (index, (file, (score, _))) in group.iter().enumerate() {
        let (first_file, (first, _)) = group[0];
        let secret = |score: &Score| score.digests.secret.clone().unwrap_or("none".to_owned());
        for (key, found, expected) in [
            ("tracks", score.digests.tracks.clone(), first.digests.tracks.clone()),
            ("secret", secret(score), secret(first)),
        ] {
            if found != expected {
                return Err(LeagueError::input(format!(
                    "{}: digests.{key}: found {found}, expected {expected} as in {}: scores on other robots cannot be compared",
                    file.display(),
                    first_file.display()
                )));
            }
        }
        let same = group[..index].iter().find(|(_, (other, _))| other.name == score.name);
        if let Some((other, _)) = same {
            return Err(LeagueError::input(format!(
                "{}: name: found a second score of `{}`, expected one; the other is {}",
                file.display(),
                score.name,
                other.display()
            )));
        }
    }
    Ok(())
}

/// The rows of a track: all simulated robots, each family and each engine, each for all modes or
/// speeds and for each of them. A submission that lacks one of them has no place in the sum.
fn of_track(scores: &[&TimedScore]) -> Vec<BoardRow> {
    let simulated: BTreeSet<&str> =
        scores.iter().flat_map(|(score, _)| score.simulated_families()).collect();
    let cells: BTreeSet<&str> = scores.iter().flat_map(|(score, _)| score.cells()).collect();
    let mut rows = Vec::new();
    for robots in robot_parts(scores) {
        let all = (cells.len() > 1).then_some(None);
        for cell in all.into_iter().chain(cells.iter().copied().map(Some)) {
            let plays = |score: &Score| {
                (matches!(robots, RobotPart::Family(_)) || score.simulated_families() == simulated)
                    && cell.map_or(score.cells() == cells, |cell| score.cells().contains(cell))
            };
            let playing = scores.iter().copied().filter(|(score, _)| plays(score));
            rows.extend(ranked(&playing.collect::<Vec<_>>(), ScorePart { robots, cell }));
        }
    }
    rows
}

/// What robots have tables: all simulated ones, each family, each engine that simulates; where there
/// is one family, it is all, and where there is one engine, too.
fn robot_parts<'a>(scores: &[&'a TimedScore]) -> Vec<RobotPart<'a>> {
    let robots = || scores.iter().flat_map(|(score, _)| &score.robots);
    let families: BTreeSet<&str> = robots().map(|robot| robot.family.as_str()).collect();
    let engines: BTreeSet<&str> = robots().map(|robot| robot.engine.as_str()).collect();
    let simulated = scores.iter().flat_map(|(score, _)| score.simulated_families());
    let has_all = simulated.collect::<BTreeSet<&str>>().len() > 1;
    let engines = engines.into_iter().filter(|engine| *engine != MEASURED);
    let engines: Vec<RobotPart> = engines.map(RobotPart::Engine).collect();
    let mut parts: Vec<RobotPart> = has_all.then_some(RobotPart::All).into_iter().collect();
    parts.extend(families.into_iter().map(RobotPart::Family));
    if engines.len() > 1 {
        parts.extend(engines);
    }
    parts
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), LeagueError> {
    let entries = std::fs::read_dir(folder)
        .map_err(|error| LeagueError::input(format!("{}: {error}", folder.display())))?;
    for entry in entries.flatten() {
        match entry.file_type() {
            Ok(kind) if kind.is_dir() => collect(&entry.path(), files)?,
            Ok(_) if entry.file_name() == SCORE && entry.path().is_file() => {
                files.push(entry.path())
            }
            _ => {}
        }
    }
    Ok(())
}

/// The rows of a part, the smallest error first.
fn ranked(scores: &[&TimedScore], part: ScorePart) -> Vec<BoardRow> {
    let mut rows: Vec<BoardRow> = scores
        .iter()
        .filter_map(|(score, times)| {
            let summary = score.summary(part)?;
            let [low_95, high_95] = summary.interval_95.unwrap_or([f64::NAN; 2]);
            Some(BoardRow {
                track: score.track.clone(),
                season: season(score),
                robots: part.robots.to_string(),
                cell: part.cell.unwrap_or(ALL).to_owned(),
                rank: 1,
                name: score.name.clone(),
                kind: score.kind.clone(),
                measure: score.measure.clone(),
                error: summary.error,
                low_95,
                high_95,
                floor: summary.floor.unwrap_or(f64::NAN),
                samples: score.real_samples.saturating_add(score.robot_samples),
                tick_ms: times.map_or(f64::NAN, |times| 1e3 * times.median_s),
                robot_count: summary.robots,
                trials: summary.trials,
                failed: summary.failures.values().sum(),
                failures: failure_words(&summary.failures),
            })
        })
        .collect();
    rows.sort_by(|left, right| {
        left.error.total_cmp(&right.error).then_with(|| left.name.cmp(&right.name))
    });
    let highest: Vec<f64> = rows.iter().map(|row| row.high_95).collect();
    for row in &mut rows {
        // Not a number, of a single robot, lies below nothing.
        row.rank = 1 + highest.iter().filter(|high_95| **high_95 < row.low_95).count() as u64;
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::league::score::{CellScore, Digests, FORMAT, Machine, RobotScore};

    fn score(name: &str, robots: &[(&str, &str)]) -> Score {
        let robot = |(index, (family, engine)): (usize, &(&str, &str))| RobotScore {
            robot: format!("{family}_1"),
            family: (*family).to_owned(),
            engine: (*engine).to_owned(),
            cells: vec![CellScore::of("answers".to_owned(), &[(0.1 * (index + 1) as f64, None)])],
        };
        let none = String::new;
        Score {
            format: FORMAT,
            name: name.to_owned(),
            authors: Vec::new(),
            track: "identify".to_owned(),
            measure: none(),
            kind: none(),
            trained_on: none(),
            licence: none(),
            real_samples: 0,
            robot_samples: 0,
            season: "development".to_owned(),
            sealed: false,
            digests: Digests {
                submission: none(),
                tracks: none(),
                robots: none(),
                program: none(),
                secret: None,
            },
            machine: Machine { system: none(), processor: none(), guards: none() },
            robots: robots.iter().enumerate().map(robot).collect(),
        }
    }

    #[test]
    fn real_robots_have_tables_of_their_own_and_do_not_count_among_all() {
        let folder = tempfile::tempdir().unwrap();
        let simulated = [("a", "rod"), ("b", "rod")];
        let with_real = [("a", "rod"), ("b", "rod"), ("v4", MEASURED)];
        for (name, robots) in [("simulated", &simulated[..]), ("also_real", &with_real)] {
            std::fs::create_dir_all(folder.path().join(name)).unwrap();
            std::fs::write(folder.path().join(name).join(SCORE), score(name, robots).json())
                .unwrap();
        }
        let rows = board(folder.path()).unwrap();
        let of = |robots: &str| {
            let rows = rows.iter().filter(|row| row.robots == robots);
            rows.map(|row| (row.name.as_str(), row.error)).collect::<Vec<_>>()
        };
        let [first, second] = of("all")[..] else { panic!("{rows:?}") };
        assert_eq!([first.0, second.0], ["also_real", "simulated"]);
        assert!((first.1 - 0.15).abs() < 1e-9 && (second.1 - 0.15).abs() < 1e-9, "{rows:?}");
        assert_eq!(of("v4").len(), 1);
        // A single engine simulates: no tables by engine.
        assert!(of("engine rod").is_empty(), "{rows:?}");
        let other = score("other", &[("a", "rod"), ("b", "mujoco")]).json();
        std::fs::write(folder.path().join("simulated").join(SCORE), other).unwrap();
        let rows = board(folder.path()).unwrap();
        let of_engine: Vec<_> = rows.iter().filter(|row| row.robots == "engine mujoco").collect();
        let [row] = of_engine[..] else { panic!("{rows:?}") };
        assert!(row.name == "other" && (row.error - 0.2).abs() < 1e-9, "{row:?}");
    }
}
