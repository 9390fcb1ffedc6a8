//! A track on one robot as an ordinary experiment, which anybody can run with `spinebench run`.

use serde::Serialize;
use serde_json::{Value, json};

use super::LeagueError;
use super::robot::LeagueRobot;
use super::track::{LeagueTrack, ReadTrack, Task};
use crate::plants::{PlantSpec, SimulatedSpec};
use crate::policies::{self, OutsidePolicy, PolicyEntry};
use crate::specs::to_yaml;

/// Who plays.
#[derive(Clone, Debug)]
pub enum Player {
    /// Policies of this program, with the data budget of the track.
    Builtin(Vec<String>),
    /// A submitted policy, in a process without network and files.
    Submitted {
        /// Its name.
        name: String,
        /// The policy.
        policy: OutsidePolicy,
    },
    /// The controllers of the floor: they know the hidden effects, and see the tip without noise.
    Floor,
}

/// Name of the mode with a weight at the tip.
const LOADED: &str = "closed_load";
/// Name of the mode in which the robot changes during a trial.
const CHANGING: &str = "changing";

/// Text of the experiment of a track on a robot.
///
/// # Errors
/// [`LeagueError::Failed`] for what YAML cannot represent.
pub fn experiment(
    read: &ReadTrack,
    robot: &LeagueRobot,
    player: &Player,
) -> Result<String, LeagueError> {
    let track = &read.track;
    let mut spec = as_json(&track.experiment)?;
    if let Some(extended) = read.extended() {
        spec["extends"] = json!(extended.display().to_string());
    }
    let (model, plant) = robots(robot, player);
    let (policies, section) = players(read, player)?;
    let further = json!({
        "name": robot.name, "seed": robot.seed.0, "seeds": 1, "model": as_json(&model)?,
        "plant": as_json(&plant)?, "policies": section, "claims": [], "figures": [],
        "modes": modes(robot)?, "runs": runs(read, &policies),
    });
    merge(&mut spec, further);
    to_yaml(&spec).map_err(LeagueError::failed)
}

/// The model that a player is given, and its robot.
fn robots(robot: &LeagueRobot, player: &Player) -> (PlantSpec, PlantSpec) {
    let simulated = |model| PlantSpec::Simulated(Box::new(SimulatedSpec::new(model, 0.0)));
    match player {
        Player::Floor => (simulated(robot.true_model()), robot.plant.without_noise()),
        _ => (simulated(robot.nominal.clone()), robot.plant.clone()),
    }
}

/// Names of the policies, and the section of the spec that describes them.
fn players(read: &ReadTrack, player: &Player) -> Result<(Vec<String>, Value), LeagueError> {
    Ok(match player {
        Player::Builtin(names) => (names.clone(), json!({})),
        Player::Floor => (read.track.floor.clone(), json!({})),
        Player::Submitted { name, policy } => {
            let process = json!({ "confined": true, "answer_s": read.track.answer_s });
            let policy = as_json(policy)?;
            (
                vec![name.clone()],
                json!({ "process": process, "outside": { (name.as_str()): policy } }),
            )
        }
    })
}

fn modes(robot: &LeagueRobot) -> Result<Value, LeagueError> {
    let load = json!([{ "tip_load": { "mass_kg": robot.load_kg } }]);
    let mut modes = json!({ LOADED: { "feedback": "closed", "effects": load } });
    if let Some(change) = &robot.change {
        modes[CHANGING] = json!({ "feedback": "closed", "change": as_json(change)? });
    }
    Ok(modes)
}

/// Samples of each robot that a policy of this program takes before its trials.
pub fn robot_samples(track: &LeagueTrack, name: &str) -> usize {
    let is_used = |entry: &PolicyEntry| entry.uses_error_model() || entry.uses_real_data();
    if policies::find(name).is_some_and(is_used) { track.samples } else { 0 }
}

fn runs(read: &ReadTrack, names: &[String]) -> Value {
    // A size applies to the policies that use it; others have none.
    let entries = || names.iter().filter_map(|name| policies::find(name));
    let size = |is_used: bool| is_used.then_some([read.track.samples]);
    let gp_points = size(entries().any(PolicyEntry::uses_error_model));
    let real_points = size(entries().any(PolicyEntry::uses_real_data));
    let cells = |modes: &[String]| json!([{ "policies": names, "modes": modes, "gp_points": gp_points, "real_points": real_points }]);
    match &read.track.task {
        Task::Reach { modes } => json!({ "forward": false, "reach": cells(modes) }),
        Task::Laps { lap_s, speeds, change } => {
            let mode = if change.is_some() { CHANGING } else { "closed" };
            let cells = cells(&[mode.to_owned()]);
            json!({ "forward": false, "pace": { "lap_s": lap_s, "speeds": speeds, "cells": cells } })
        }
        Task::Identify(_) | Task::Name(_) => json!({}),
    }
}

fn as_json(value: &impl Serialize) -> Result<Value, LeagueError> {
    serde_json::to_value(value).map_err(LeagueError::failed)
}

/// Puts `further` over `value`, mapping by mapping.
fn merge(value: &mut Value, further: Value) {
    match (value, further) {
        (Value::Object(value), Value::Object(further)) => {
            for (key, part) in further {
                merge(value.entry(key).or_insert(Value::Null), part);
            }
        }
        (value, further) => *value = further,
    }
}
