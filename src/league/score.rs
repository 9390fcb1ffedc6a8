//! Scores: what a submission reached on each robot, and on all of them.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::robot::{LeagueRobot, MEASURED};
use super::season::is_season;
use super::{LeagueError, NAME, is_name};
use crate::math::distribution::wilson_95;
use crate::math::summary::{interval_95, mean};
use crate::rows::league::{ALL, SHARE_NOT_NAMED};

/// Error of a trial that failed, in lengths of the robot: as if the tip were that far away.
pub const FAILED: f64 = 1.0;

/// What `score.json` holds: the same bytes for the same submission, robots and program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Score {
    /// Version of this file.
    pub format: u64,
    /// Name of the submission.
    pub name: String,
    /// Its authors.
    pub authors: Vec<String>,
    /// The track.
    pub track: String,
    /// What its numbers are: `error over length` or `share not named`.
    pub measure: String,
    /// Kind of the policy, or `answers`.
    pub kind: String,
    /// What it was trained on.
    pub trained_on: String,
    /// Licence.
    pub licence: String,
    /// Measured samples before the trials.
    pub real_samples: u64,
    /// Samples of each robot that it may take.
    pub robot_samples: u64,
    /// The season; `development` without one.
    pub season: String,
    /// Whether the robots were sealed when it was scored.
    pub sealed: bool,
    /// Digests of what the score depends on.
    pub digests: Digests,
    /// The machine.
    pub machine: Machine,
    /// Each robot.
    pub robots: Vec<RobotScore>,
}

/// Digests of what a score depends on, in hexadecimal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Digests {
    /// All files of the submission.
    pub submission: String,
    /// Tracks, models and engines.
    pub tracks: String,
    /// The robots as they were drawn.
    pub robots: String,
    /// Version of the program.
    pub program: String,
    /// Hash of the secret that drew the robots, where they were sealed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub secret: Option<String>,
}

/// Where a score was computed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Operating system and architecture.
    pub system: String,
    /// Name of the processor.
    pub processor: String,
    /// What confined the policy; empty for one of this program and for answers.
    pub guards: String,
}

/// A submission on one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotScore {
    /// Name of the robot.
    pub robot: String,
    /// Its family.
    pub family: String,
    /// The engine that plays it.
    pub engine: String,
    /// Its trials by mode, or by speed, or as answers.
    pub cells: Vec<CellScore>,
}

impl RobotScore {
    /// Cells of a robot.
    pub(super) fn of(robot: &LeagueRobot, cells: Vec<CellScore>) -> RobotScore {
        RobotScore {
            robot: robot.name.clone(),
            family: robot.family.clone(),
            engine: robot.engine.clone(),
            cells,
        }
    }

    /// Names of its modes or speeds.
    fn cells(&self) -> BTreeSet<&str> {
        self.cells.iter().map(|cell| cell.cell.as_str()).collect()
    }

    /// Mean over its cells.
    pub fn error(&self) -> f64 {
        mean(&self.cells.iter().map(|cell| cell.error).collect::<Vec<_>>())
    }
}

/// Trials of one mode or speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellScore {
    /// `open`, `closed`, `speed 2`, `answers` …
    pub cell: String,
    /// Number of trials.
    pub trials: u64,
    /// Trials that failed, by their status.
    pub failures: Failures,
    /// Mean error; a trial that failed counts 1.
    pub error: f64,
    /// Mean error of the floor; none where no controller of the floor plays.
    pub floor: Option<f64>,
}

/// Error of a trial, and its status where it failed.
pub type ScoredTrial = (f64, Option<String>);

/// Numbers of failed trials by their status.
pub type Failures = BTreeMap<String, u64>;

impl CellScore {
    /// The mean over trials: errors, and statuses of those that failed.
    pub fn of(cell: String, trials: &[ScoredTrial]) -> CellScore {
        let mut failures = Failures::new();
        let errors = trials.iter().map(|(error, failure)| {
            let Some(status) = failure
                .as_ref()
                .map(|status| status.as_str())
                .or_else(|| (!error.is_finite()).then_some("not measured"))
            else {
                return *error;
            };
            *failures.entry(status.to_owned()).or_default() += 1;
            FAILED
        });
        let errors: Vec<f64> = errors.collect();
        // Nanometres of a metre: what a table shows, and no more.
        CellScore {
            cell,
            trials: errors.len() as u64,
            failures,
            error: rounded(mean(&errors)),
            floor: None,
        }
    }

    /// Refuses what no run can have written.
    fn check(&self) -> Result<(), String> {
        let CellScore { trials, failures, error, floor, .. } = self;
        let failed = failures.values().try_fold(0_u64, |sum, count| sum.checked_add(*count));
        if !(1..=MAX_TRIALS).contains(trials) || failed.is_none_or(|failed| failed > *trials) {
            return Err(format!(
                "found {trials} trials with failures {failures:?}, expected 1 to {MAX_TRIALS} trials, and no more failures"
            ));
        }
        if *error < 0.0 || floor.is_some_and(|floor| floor < 0.0) {
            return Err(format!("found error {error}, floor {floor:?}, expected none below 0"));
        }
        Ok(())
    }
}

/// The failures of all `cells`.
pub fn failures<'a>(cells: impl IntoIterator<Item = &'a CellScore>) -> Failures {
    let mut sum = Failures::new();
    for (status, count) in cells.into_iter().flat_map(|cell| &cell.failures) {
        *sum.entry(status.clone()).or_default() += count;
    }
    sum
}

/// Statuses with their numbers: `policy: late 3, missed detection 1`.
pub fn failure_words(failures: &Failures) -> String {
    let words: Vec<String> =
        failures.iter().map(|(status, count)| format!("{status} {count}")).collect();
    words.join(", ")
}

fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// Some robots of a score.
#[derive(Clone, Copy, Debug, Default)]
pub enum RobotPart<'a> {
    /// All simulated ones: real robots play only where their recordings are.
    #[default]
    All,
    /// Those of a family.
    Family(&'a str),
    /// Those that an engine plays.
    Engine(&'a str),
}

impl RobotPart<'_> {
    fn holds(self, robot: &RobotScore) -> bool {
        match self {
            RobotPart::All => robot.engine != MEASURED,
            RobotPart::Family(family) => robot.family == family,
            RobotPart::Engine(engine) => robot.engine == engine,
        }
    }
}

impl std::fmt::Display for RobotPart<'_> {
    fn fmt(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            RobotPart::All => write!(out, "{ALL}"),
            RobotPart::Family(family) => write!(out, "{family}"),
            RobotPart::Engine(engine) => write!(out, "engine {engine}"),
        }
    }
}

/// Part of a score: some robots; trials of a mode or speed, or all.
#[derive(Clone, Copy, Debug, Default)]
pub struct ScorePart<'a> {
    /// The robots.
    pub robots: RobotPart<'a>,
    /// Mode or speed.
    pub cell: Option<&'a str>,
}

/// A score on a part of its trials.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Mean error over robots.
    pub error: f64,
    /// Its 95 % interval over robots: Student's t, cut at zero; Wilson's for a share of robots.
    /// None for a single robot.
    pub interval_95: Option<[f64; 2]>,
    /// Mean of the floor; none where a robot has none.
    pub floor: Option<f64>,
    /// Robots.
    pub robots: u64,
    /// Trials.
    pub trials: u64,
    /// Trials that failed.
    pub failures: Failures,
}

impl Score {
    /// Names of the modes or speeds that it played on each robot.
    pub fn cells(&self) -> BTreeSet<&str> {
        let cells = self.robots.iter().map(RobotScore::cells);
        cells.reduce(|all, own| &all & &own).unwrap_or_default()
    }

    /// Families of its simulated robots.
    pub fn simulated_families(&self) -> BTreeSet<&str> {
        let simulated = self.robots.iter().filter(|robot| RobotPart::All.holds(robot));
        simulated.map(|robot| robot.family.as_str()).collect()
    }

    /// The score on a part of its trials; none where it has none of them.
    pub fn summary(&self, part: ScorePart) -> Option<Summary> {
        let robots = self.robots.iter().filter(|robot| part.robots.holds(robot));
        let of_robot = |robot: &RobotScore| -> Vec<CellScore> {
            let cells =
                robot.cells.iter().filter(|cell| part.cell.is_none_or(|name| cell.cell == name));
            cells.cloned().collect()
        };
        let robots: Vec<Vec<CellScore>> =
            robots.map(of_robot).filter(|cells| !cells.is_empty()).collect();
        if robots.is_empty() {
            return None;
        }
        let mean_of = |cells: &Vec<CellScore>, value: fn(&CellScore) -> f64| {
            mean(&cells.iter().map(value).collect::<Vec<f64>>())
        };
        let over_robots = |value: fn(&CellScore) -> f64| -> Vec<f64> {
            robots.iter().map(|cells| mean_of(cells, value)).collect()
        };
        let errors = over_robots(|cell| cell.error);
        let floor = mean(&over_robots(|cell| cell.floor.unwrap_or(f64::NAN)));
        let cells = || robots.iter().flatten();
        Some(Summary {
            error: mean(&errors),
            interval_95: self.interval_95(&errors),
            floor: floor.is_finite().then_some(floor),
            robots: robots.len() as u64,
            trials: cells().map(|cell| cell.trials).sum(),
            failures: failures(cells()),
        })
    }

    /// 95 % interval of the mean over robots; none for a single one.
    fn interval_95(&self, errors: &[f64]) -> Option<[f64; 2]> {
        let [low, high] = interval_95(errors)?;
        Some(if self.measure == SHARE_NOT_NAMED {
            let not_named = errors.iter().filter(|error| **error > 0.0);
            wilson_95(not_named.count() as u64, errors.len() as u64)
        } else {
            // No error is negative.
            [low.max(0.0), high]
        })
    }

    /// Reads a score.
    ///
    /// # Errors
    /// [`LeagueError::Input`] for a file that is no score.
    pub fn read(file: &std::path::Path) -> Result<Score, LeagueError> {
        let wrong = |words: String| LeagueError::input(format!("{}: {words}", file.display()));
        let text = std::fs::read_to_string(file).map_err(|error| wrong(error.to_string()))?;
        let score: Score = serde_json::from_str(&text).map_err(|error| {
            wrong(format!("{error}, expected a score of `spinebench league score`"))
        })?;
        if score.format != FORMAT {
            return Err(wrong(format!("format: found {}, expected {FORMAT}", score.format)));
        }
        score.check().map_err(wrong)?;
        Ok(score)
    }

    /// Refuses what no run can have written.
    fn check(&self) -> Result<(), String> {
        let own = [("name", &self.name), ("track", &self.track)];
        let robots = self
            .robots
            .iter()
            .flat_map(|robot| [("robot", &robot.robot), ("family", &robot.family)]);
        if let Some((key, name)) = own.into_iter().chain(robots).find(|(_, name)| !is_name(name)) {
            return Err(format!("{key}: found `{name}`, expected {NAME}"));
        }
        let Score { season, sealed, digests: Digests { secret, .. }, .. } = self;
        if !is_season(season, *sealed) || *sealed != secret.is_some() {
            return Err(format!(
                "season: found `{season}`, sealed: {sealed}, digests.secret: {secret:?}, expected a season, and a secret where it is sealed"
            ));
        }
        if self.robots.is_empty() || self.robots.iter().any(|robot| robot.cells.is_empty()) {
            return Err("robots: found none, or one without trials, expected trials".to_owned());
        }
        let mut seen = BTreeSet::new();
        for (robot, cell) in
            self.robots.iter().flat_map(|robot| robot.cells.iter().map(move |cell| (robot, cell)))
        {
            let place = format!("robots: {}: {}", robot.robot, cell.cell);
            cell.check().map_err(|words| format!("{place}: {words}"))?;
            if !seen.insert((&robot.robot, &cell.cell)) {
                return Err(format!("{place}: found a second time, expected once"));
            }
        }
        Ok(())
    }

    /// The text of its file.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

/// Most trials in a cell of a score.
const MAX_TRIALS: u64 = 1_000_000_000;

/// Version of `score.json`.
pub const FORMAT: u64 = 1;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_trial_counts_as_one_length_and_is_named() {
        let trials =
            [(0.01, None), (0.03, None), (0.02, Some("policy: late".to_owned())), (f64::NAN, None)];
        let cell = CellScore::of("closed".to_owned(), &trials);
        assert!((cell.error - (0.01 + 0.03 + 1.0 + 1.0) / 4.0).abs() < 1e-12);
        assert_eq!(failure_words(&failures([&cell])), "not measured 1, policy: late 1");
    }
}
