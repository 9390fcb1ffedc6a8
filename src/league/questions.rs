//! Questions: recordings of the robots of a track, and what is asked of them.

use super::LeagueError;
use super::robot::{LeagueRobot, RobotQuestion};
use super::track::{QuestionPlan, Task};
use crate::base::{Plant, Seed};
use crate::benchmark::{Commands, explore_commands};
use crate::data::{Actuation, Recording};
use crate::tasks::{ExploreOptions, record_trial};

/// The recordings of a task, where it is one of questions.
pub fn recordings(task: &Task) -> Option<QuestionPlan> {
    match task {
        Task::Identify(recordings) | Task::Name(recordings) => Some(*recordings),
        Task::Reach { .. } | Task::Laps { .. } => None,
    }
}

/// What is asked of a robot: a simulated one is recorded, of a real one the rows are there.
///
/// # Errors
/// [`LeagueError::Failed`] for a robot that cannot follow.
pub fn question(
    robot: &LeagueRobot,
    recordings: &QuestionPlan,
) -> Result<RobotQuestion, LeagueError> {
    if let Some(measured) = &robot.measured {
        return Ok(measured.clone());
    }
    let QuestionPlan { trials, asked, rows, step_s, .. } = *recordings;
    let failed = |error: String| LeagueError::failed(format!("{}: {error}", robot.name));
    let travel_m = robot.travel_m();
    let options = ExploreOptions {
        points: (trials + asked) * rows,
        trajectories: trials + asked,
        max_step_m: recordings.step_share * travel_m,
        max_pull_m: recordings.pull_share * travel_m,
    };
    let commands = explore_commands(&robot.nominal, &options, step_s, robot.seed.child("commands"))
        .map_err(|error| failed(error.to_string()))?;
    let [given, asked] =
        [0..trials, trials..trials + asked].map(|range| recording(&commands, range));
    let build = |plant: &crate::plants::PlantSpec| plant.build(step_s).map_err(failed);
    let noise = robot.seed.child("noise");
    let given = measured(build(&robot.plant)?.as_mut(), &given, noise)
        .map_err(|error| failed(error.to_string()))?;
    let played = measured(build(&robot.plant.without_noise())?.as_mut(), &asked, noise)
        .map_err(|error| failed(error.to_string()))?;
    Ok(RobotQuestion { given, asked, tips_m: played.tip_m.unwrap_or_default() })
}

/// The commands of some trials.
fn recording(commands: &Commands, trials: std::ops::Range<usize>) -> Recording {
    let tendons = commands.trials.first().map_or(0, crate::base::Rows::width);
    let mut recording = Recording::new(Actuation::Lengths, tendons);
    for (number, rows) in
        commands.trials.iter().enumerate().filter(|(number, _)| trials.contains(number))
    {
        for (row, pulls_m) in rows.iter().enumerate() {
            recording.trial.push(number as u64);
            recording.time_s.push(row as f64 * commands.step_s);
            recording.commands.push(pulls_m);
        }
    }
    recording
}

/// What the tracker sees of the commands, trial by trial.
fn measured(
    plant: &mut dyn Plant,
    commands: &Recording,
    seed: Seed,
) -> Result<Recording, crate::base::PlantError> {
    let mut all = Recording::new(Actuation::Lengths, commands.tendons());
    let mut tips_m = Vec::new();
    for (trial, rows) in commands.trials() {
        let part = record_trial(plant, commands, rows, seed.index(trial))?;
        all.trial.extend(&part.trial);
        all.time_s.extend(&part.time_s);
        part.commands.iter().for_each(|row| all.commands.push(row));
        tips_m.extend(part.tip_m.unwrap_or_default());
    }
    all.tip_m = Some(tips_m);
    Ok(all)
}
