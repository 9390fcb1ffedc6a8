//! Answers to questions, as tables beside a submission.

use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::LeagueError;
use super::questions::{asked, plan_of, true_tips_m};
use super::robot::LeagueRobot;
use super::score::{CellScore, RobotScore, ScoredTrial};
use super::track::{QuestionPlan, ReadTrack, Task};
use crate::base::{Point3, distance_m};
use crate::data::Recording;
use crate::data::tables::{read_csv, read_csv_beside};
use crate::effects::card;
use crate::math::summary::root_mean_square;
use crate::rows::league::ANSWERS;

/// File of the effects that answers name.
pub const NAMES: &str = "names.csv";

/// A predicted tip: a row of `ROBOT.csv`. Other columns, as `simulate` writes them, are passed over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictedTip {
    /// Trial of the question.
    pub trial: u64,
    /// Time in it, seconds.
    pub time_s: f64,
    /// Tip, metres.
    pub tip_x_m: f64,
    /// Tip, metres.
    pub tip_y_m: f64,
    /// Tip, metres.
    pub tip_z_m: f64,
}

/// The columns of [`PredictedTip`].
const TIP_COLUMNS: [&str; 5] = ["trial", "time_s", "tip_x_m", "tip_y_m", "tip_z_m"];

/// The effects that are named for a robot: a row of `names.csv`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectAnswer {
    /// Name of the robot.
    pub robot: String,
    /// Names in the catalogue, separated by spaces; empty: nothing is missing.
    pub effects: String,
}

/// Answers of a submission, robot by robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Answers {
    /// Tips under the commands that are asked.
    Tips(QuestionPlan, Vec<TipsAnswer>),
    /// Names of effects.
    Effects(Vec<Vec<String>>),
}

/// The commands that are asked of a robot, and the predicted tips, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct TipsAnswer {
    asked: Recording,
    tips_m: Vec<Point3>,
}

impl Answers {
    /// Reads the answers in a folder to the questions of a track.
    ///
    /// # Errors
    /// [`LeagueError::Input`] for files and rows that are not as asked, all of them at once, and for
    /// a track without questions.
    pub fn read(
        track: &ReadTrack,
        robots: &[LeagueRobot],
        folder: &Path,
    ) -> Result<Answers, LeagueError> {
        let plan = plan_of(track)?;
        match &track.track.task {
            Task::Name(_) => named(robots, folder).map(Answers::Effects),
            _ => predicted(&plan, robots, folder).map(|tips| Answers::Tips(plan, tips)),
        }
    }

    /// What the answers reach on each of the robots that they were read for.
    ///
    /// # Errors
    /// [`LeagueError::Failed`] for a robot that cannot follow.
    pub fn judge(&self, robots: &[LeagueRobot]) -> Result<Vec<RobotScore>, LeagueError> {
        let trials: Vec<ScoredTrial> = match self {
            Answers::Effects(named) => {
                named.iter().zip(robots).map(|(answer, robot)| named_trial(answer, robot)).collect()
            }
            Answers::Tips(plan, tips) => {
                let trial = |(answer, robot)| predicted_trial(answer, robot, plan);
                tips.par_iter().zip(robots).map(trial).collect::<Result<_, _>>()?
            }
        };
        let score = |(robot, trial): (&LeagueRobot, ScoredTrial)| {
            RobotScore::of(robot, vec![CellScore::of(ANSWERS.to_owned(), &[trial])])
        };
        Ok(robots.iter().zip(trials).map(score).collect())
    }
}

/// The answers, or all faults of all robots.
fn all_or_faults<T>(answers: Vec<Result<T, String>>) -> Result<Vec<T>, LeagueError> {
    let faults: Vec<&str> =
        answers.iter().filter_map(|answer| answer.as_ref().err().map(String::as_str)).collect();
    if !faults.is_empty() {
        return Err(LeagueError::Input(faults.join("\n")));
    }
    Ok(answers.into_iter().flatten().collect())
}

/// The effects that `names.csv` names for each robot.
fn named(robots: &[LeagueRobot], folder: &Path) -> Result<Vec<Vec<String>>, LeagueError> {
    let file = folder.join(NAMES);
    let rows: Vec<EffectAnswer> = read_csv(&file).map_err(LeagueError::input)?;
    let file = file.display();
    let answer = |robot: &LeagueRobot| {
        let mut own = rows.iter().enumerate().filter(|(_, row)| row.robot == robot.name);
        let (Some((row, answer)), None) = (own.next(), own.next()) else {
            let count = rows.iter().filter(|row| row.robot == robot.name).count();
            return Err(format!("{file}: found {count} rows of `{}`, expected one", robot.name));
        };
        let effects: Vec<String> = answer.effects.split_whitespace().map(str::to_owned).collect();
        let is_wrong = |(place, name): &(usize, &String)| {
            card(name).is_none() || effects[..*place].contains(name)
        };
        match effects.iter().enumerate().find(is_wrong) {
            None => Ok(effects),
            Some((_, wrong)) => Err(format!(
                "{file}:{}: effects: found `{wrong}`, expected different names of `spinebench effects`, or nothing",
                row + 2
            )),
        }
    };
    all_or_faults(robots.iter().map(answer).collect())
}

/// The tips that `ROBOT.csv` predicts for each robot.
fn predicted(
    plan: &QuestionPlan,
    robots: &[LeagueRobot],
    folder: &Path,
) -> Result<Vec<TipsAnswer>, LeagueError> {
    let of = |robot: &LeagueRobot| folder.join(format!("{}.csv", robot.name));
    // Before commands are computed, which takes a while.
    let present = robots.iter().map(|robot| {
        let file = of(robot);
        if file.is_file() { Ok(()) } else { Err(format!("{}: found no such file", file.display())) }
    });
    all_or_faults(present.collect())?;
    let answer = |robot: &LeagueRobot| {
        let asked = asked(robot, plan)?;
        Ok(read_tips(&of(robot), &asked).map(|tips_m| TipsAnswer { asked, tips_m }))
    };
    let answers: Result<Vec<Result<TipsAnswer, String>>, LeagueError> =
        robots.par_iter().map(answer).collect();
    all_or_faults(answers?)
}

/// The predicted tips in a file, whose rows must be those that are asked, metres.
fn read_tips(file: &Path, asked: &Recording) -> Result<Vec<Point3>, String> {
    let is_beside = |column: &str| !TIP_COLUMNS.contains(&column);
    let (_, rows): (_, Vec<PredictedTip>) =
        read_csv_beside(file, is_beside).map_err(|error| error.to_string())?;
    let file = file.display();
    if rows.len() != asked.trial.len() {
        let (found, expected) = (rows.len(), asked.trial.len());
        return Err(format!("{file}: found {found} rows, expected the {expected} of the question"));
    }
    let tip_m = |(row, predicted): (usize, &PredictedTip)| {
        let (trial, time_s) = (asked.trial[row], asked.time_s[row]);
        let is_asked = predicted.trial == trial && (predicted.time_s - time_s).abs() < 1e-6;
        let tip_m: Point3 = [predicted.tip_x_m, predicted.tip_y_m, predicted.tip_z_m];
        let row = row + 2;
        if !is_asked {
            let PredictedTip { trial: found, time_s: found_s, .. } = predicted;
            return Err(format!(
                "{file}:{row}: found trial {found} at {found_s:.3} s, expected trial {trial} at {time_s:.3} s"
            ));
        }
        if !tip_m.iter().all(|value| value.is_finite()) {
            return Err(format!("{file}:{row}: found the tip {tip_m:?}, expected finite numbers"));
        }
        Ok(tip_m)
    };
    rows.iter().enumerate().map(tip_m).collect()
}

/// Root mean square of the distances of the predicted tips from the true ones, over the length.
fn predicted_trial(
    answer: &TipsAnswer,
    robot: &LeagueRobot,
    plan: &QuestionPlan,
) -> Result<ScoredTrial, LeagueError> {
    let true_tips_m = true_tips_m(robot, &answer.asked, plan)?;
    let distances_m: Vec<f64> =
        answer.tips_m.iter().zip(&true_tips_m).map(|(tip_m, tip)| distance_m(tip_m, tip)).collect();
    Ok((root_mean_square(&distances_m) / robot.length_m(), None))
}

/// Error 0 where exactly the hidden effects are named; otherwise 1, and what went wrong in the terms
/// of fault diagnosis (Isermann, *Fault-Diagnosis Systems*, 2006).
fn named_trial(answer: &[String], robot: &LeagueRobot) -> ScoredTrial {
    let mut answered: Vec<&str> = answer.iter().map(String::as_str).collect();
    let mut hidden: Vec<&str> = robot.effects.iter().map(|effect| effect.card().name).collect();
    answered.sort_unstable();
    hidden.sort_unstable();
    if answered == hidden {
        return (0.0, None);
    }
    let fault = match (hidden.is_empty(), answered.is_empty()) {
        (true, _) => "false alarm",
        (false, true) => "missed detection",
        (false, false) => "wrong isolation",
    };
    (1.0, Some(fault.to_owned()))
}
