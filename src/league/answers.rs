//! Answers to questions, as tables beside a submission.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::LeagueError;
use super::questions::{question, recordings};
use super::robot::{LeagueRobot, RobotQuestion};
use super::score::{CellScore, RobotScore, ScoredTrial};
use super::track::{ReadTrack, Task};
use crate::base::{Point3, distance_m};
use crate::data::tables::read_csv;
use crate::data::write_atomic;
use crate::effects::card;
use crate::math::summary::root_mean_square;
use crate::specs::model_text;

/// File of the effects that answers name.
pub const NAMES: &str = "names.csv";

/// A predicted tip: a row of `ROBOT.csv`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictedTip {
    /// ScoredTrial of the question.
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

/// The effects that are named for a robot: a row of `names.csv`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectAnswer {
    /// Name of the robot.
    pub robot: String,
    /// Names in the catalogue, separated by spaces; empty: nothing is missing.
    pub effects: String,
}

/// Writes the questions of all robots: for each a folder with the nominal model, what is given,
/// and where tips are asked for, their commands.
///
/// # Errors
/// [`LeagueError`] for a track without questions, and for what cannot be recorded or written.
pub fn write_questions(
    read: &ReadTrack,
    robots: &[LeagueRobot],
    out: &Path,
) -> Result<(), LeagueError> {
    robots.par_iter().try_for_each(|robot| {
        let folder = out.join(&robot.name);
        std::fs::create_dir_all(&folder).map_err(LeagueError::failed)?;
        let RobotQuestion { given, asked, .. } = asked_of(read, robot)?;
        let model = model_text(&robot.nominal).map_err(LeagueError::failed)?;
        write_atomic(&folder.join("model.yaml"), model.as_bytes()).map_err(LeagueError::failed)?;
        given.write(&folder.join("given.csv")).map_err(LeagueError::failed)?;
        if !asked.trial.is_empty() {
            asked.write(&folder.join("asked.csv")).map_err(LeagueError::failed)?;
        }
        Ok(())
    })
}

fn asked_of(read: &ReadTrack, robot: &LeagueRobot) -> Result<RobotQuestion, LeagueError> {
    let recordings = recordings(&read.track.task).ok_or_else(|| {
        LeagueError::input(format!(
            "track {}: found trials, expected a track with questions",
            read.name
        ))
    })?;
    question(robot, &recordings)
}

/// What answers in a folder reach on each robot.
///
/// # Errors
/// [`LeagueError::Input`] for a file or a row that is not as asked, all of them at once.
pub fn judge(
    read: &ReadTrack,
    robots: &[LeagueRobot],
    folder: &Path,
) -> Result<Vec<RobotScore>, LeagueError> {
    let names = match read.track.task {
        Task::Name(_) => named(folder)?,
        _ => BTreeMap::new(),
    };
    let of = |robot: &LeagueRobot| folder.join(format!("{}.csv", robot.name));
    let names_robots = matches!(read.track.task, Task::Name(_));
    // Before robots are recorded, which takes minutes.
    let missing = robots.iter().map(of).filter(|file| !names_robots && !file.is_file());
    let mut faults: Vec<String> =
        missing.map(|file| format!("{}: found no such file", file.display())).collect();
    let answered = if faults.is_empty() { robots } else { &[] };
    let trial = |robot: &LeagueRobot| -> Result<Result<ScoredTrial, String>, LeagueError> {
        Ok(if names_robots {
            names.get(&robot.name).map(|answer| named_trial(answer, robot)).ok_or_else(|| {
                format!("{}: found no row of `{}`", folder.join(NAMES).display(), robot.name)
            })
        } else {
            predicted(&of(robot), &asked_of(read, robot)?)
                .map(|error_m| (error_m / robot.length_m(), None))
        })
    };
    let trials: Vec<_> = answered.par_iter().map(trial).collect::<Result<_, _>>()?;
    let mut scores = Vec::new();
    for (robot, trial) in answered.iter().zip(trials) {
        match trial {
            Err(fault) => faults.push(fault),
            Ok(trial) => scores.push(RobotScore {
                robot: robot.name.clone(),
                family: robot.family.clone(),
                engine: robot.engine.clone(),
                cells: vec![CellScore::of("answers".to_owned(), &[trial])],
            }),
        }
    }
    if faults.is_empty() { Ok(scores) } else { Err(LeagueError::Input(faults.join("\n"))) }
}

fn named(folder: &Path) -> Result<BTreeMap<String, String>, LeagueError> {
    let file = folder.join(NAMES);
    let rows: Vec<EffectAnswer> = read_csv(&file).map_err(LeagueError::input)?;
    for (row, answer) in rows.iter().enumerate() {
        if let Some(found) = answer.effects.split_whitespace().find(|name| card(name).is_none()) {
            return Err(LeagueError::input(format!(
                "{}:{}: effects: found `{found}`, expected names of `spinebench effects`",
                file.display(),
                row + 2
            )));
        }
    }
    Ok(rows.into_iter().map(|row| (row.robot, row.effects)).collect())
}

/// Error 0 where exactly the hidden effects are named; otherwise 1, and what went wrong in the terms
/// of fault diagnosis (Isermann, *Fault-Diagnosis Systems*, 2006).
fn named_trial(answer: &str, robot: &LeagueRobot) -> ScoredTrial {
    let mut answered: Vec<&str> = answer.split_whitespace().collect();
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

/// Root mean square of the distance of predicted tips from the true ones, metres.
fn predicted(file: &Path, question: &RobotQuestion) -> Result<f64, String> {
    let rows: Vec<PredictedTip> = read_csv(file).map_err(|error| error.to_string())?;
    let asked = &question.asked;
    if rows.len() != asked.trial.len() {
        return Err(format!(
            "{}: found {} rows, expected the {} of the question",
            file.display(),
            rows.len(),
            asked.trial.len()
        ));
    }
    let mut distances_m = Vec::with_capacity(rows.len());
    for (row, predicted) in rows.iter().enumerate() {
        let is_asked = predicted.trial == asked.trial[row]
            && (predicted.time_s - asked.time_s[row]).abs() < 1e-6;
        let tip_m: Point3 = [predicted.tip_x_m, predicted.tip_y_m, predicted.tip_z_m];
        if !is_asked || !tip_m.iter().all(|value| value.is_finite()) {
            return Err(format!(
                "{}:{}: found trial {} at {:.3} s, expected trial {} at {:.3} s with a finite tip",
                file.display(),
                row + 2,
                predicted.trial,
                predicted.time_s,
                asked.trial[row],
                asked.time_s[row]
            ));
        }
        distances_m.push(distance_m(&tip_m, &question.tips_m[row]));
    }
    Ok(root_mean_square(&distances_m))
}
