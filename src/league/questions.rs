//! Questions: recordings of the robots of a track, and what is asked of them.

use std::path::Path;

use rayon::prelude::*;

use super::LeagueError;
use super::robot::LeagueRobot;
use super::track::{QuestionPlan, ReadTrack, Task};
use crate::base::{Plant, Point3, Seed};
use crate::benchmark::explore_commands;
use crate::data::{Actuation, Recording, write_atomic};
use crate::plants::PlantSpec;
use crate::specs::model_text;
use crate::tasks::{ExploreOptions, record_trial};

/// The recordings of a task, where it is one of questions.
pub fn recordings(task: &Task) -> Option<QuestionPlan> {
    match task {
        Task::Identify(recordings) | Task::Name(recordings) => Some(*recordings),
        Task::Reach { .. } | Task::Laps { .. } => None,
    }
}

/// The recordings of a track with questions.
///
/// # Errors
/// [`LeagueError::Input`] for a track with trials.
pub(super) fn plan_of(read: &ReadTrack) -> Result<QuestionPlan, LeagueError> {
    recordings(&read.track.task).ok_or_else(|| {
        LeagueError::input(format!(
            "track {}: found trials, expected a track with questions",
            read.name
        ))
    })
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
    let plan = plan_of(read)?;
    robots.par_iter().try_for_each(|robot| {
        let folder = out.join(&robot.name);
        std::fs::create_dir_all(&folder).map_err(LeagueError::failed)?;
        let model = model_text(&robot.nominal).map_err(LeagueError::failed)?;
        write_atomic(&folder.join("model.yaml"), model.as_bytes()).map_err(LeagueError::failed)?;
        let [given, asked] = match &robot.measured {
            Some(measured) => [measured.given.clone(), measured.asked.clone()],
            None => {
                let [given, asked] = commands(robot, &plan)?;
                [record(robot, &robot.plant, &given, &plan)?, asked]
            }
        };
        given.write(&folder.join("given.csv")).map_err(LeagueError::failed)?;
        if !asked.trial.is_empty() {
            asked.write(&folder.join("asked.csv")).map_err(LeagueError::failed)?;
        }
        Ok(())
    })
}

/// The commands whose tips are asked for; without rows where none are.
///
/// # Errors
/// [`LeagueError::Failed`] where the nominal robot cannot follow.
pub fn asked(robot: &LeagueRobot, plan: &QuestionPlan) -> Result<Recording, LeagueError> {
    match &robot.measured {
        Some(measured) => Ok(measured.asked.clone()),
        None => commands(robot, plan).map(|[_, asked]| asked),
    }
}

/// The tips after the commands that are `asked`, metres; of a simulated robot without noise.
///
/// # Errors
/// [`LeagueError::Failed`] for a robot that cannot follow.
pub fn true_tips_m(
    robot: &LeagueRobot,
    asked: &Recording,
    plan: &QuestionPlan,
) -> Result<Vec<Point3>, LeagueError> {
    match &robot.measured {
        Some(measured) => Ok(measured.tips_m.clone()),
        None => record(robot, &robot.plant.without_noise(), asked, plan)
            .map(|played| played.tip_m.unwrap_or_default()),
    }
}

/// The commands of a simulated robot: those that are given, and those that are asked.
fn commands(robot: &LeagueRobot, plan: &QuestionPlan) -> Result<[Recording; 2], LeagueError> {
    let QuestionPlan { trials, asked, rows, step_s, .. } = *plan;
    let travel_m = robot.travel_m();
    let options = ExploreOptions {
        points: (trials + asked) * rows,
        trajectories: trials + asked,
        max_step_m: plan.step_share * travel_m,
        max_pull_m: plan.pull_share * travel_m,
    };
    let commands = explore_commands(&robot.nominal, &options, step_s, robot.seed.child("commands"))
        .map_err(|error| LeagueError::failed(format!("{}: {error}", robot.name)))?;
    let recording = |range: std::ops::Range<usize>| {
        let tendons = commands.trials.first().map_or(0, crate::base::Rows::width);
        let mut recording = Recording::new(Actuation::Lengths, tendons);
        for (number, rows) in commands.trials.iter().enumerate().take(range.end).skip(range.start) {
            for (row, pulls_m) in rows.iter().enumerate() {
                recording.trial.push(number as u64);
                recording.time_s.push(row as f64 * step_s);
                recording.commands.push(pulls_m);
            }
        }
        recording
    };
    Ok([recording(0..trials), recording(trials..trials + asked)])
}

/// What the tracker sees of the commands, trial by trial.
fn record(
    robot: &LeagueRobot,
    plant: &PlantSpec,
    commands: &Recording,
    plan: &QuestionPlan,
) -> Result<Recording, LeagueError> {
    let failed = |error: String| LeagueError::failed(format!("{}: {error}", robot.name));
    let mut plant: Box<dyn Plant> = plant.build(plan.step_s).map_err(failed)?;
    let noise: Seed = robot.seed.child("noise");
    let mut all = Recording::new(Actuation::Lengths, commands.tendons());
    let mut tips_m = Vec::new();
    for (trial, rows) in commands.trials() {
        let part = record_trial(plant.as_mut(), commands, rows, noise.index(trial))
            .map_err(|error| failed(error.to_string()))?;
        all.trial.extend(&part.trial);
        all.time_s.extend(&part.time_s);
        part.commands.iter().for_each(|row| all.commands.push(row));
        tips_m.extend(part.tip_m.unwrap_or_default());
    }
    all.tip_m = Some(tips_m);
    Ok(all)
}
