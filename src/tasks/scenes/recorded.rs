//! Scenes of recordings: the robot of a model under the commands, beside what was measured.

use std::path::Path;

use super::robot_shape::{scene_robot, tracked_at_stations};
use crate::base::Point3;
use crate::data::recording::Extra;
use crate::data::scene::{Scene, SceneFrame, SceneRobot, StationPose};
use crate::data::{DataError, Recording};
use crate::effects::Model;
use crate::tasks::{SimulationOptions, of_tendons, simulate_recording};

/// The robot of `model` under the commands of `recording`, which was read from `file`, with the
/// measured tip and points. Times continue from trial to trial; poses at rest are one second apart.
///
/// # Errors
/// [`DataError`] for commands that are not those of the model's tendons or drives.
pub fn scene_of_recording(
    name: &str,
    file: &Path,
    recording: &Recording,
    model: &Model,
    at_rest: bool,
) -> Result<Scene, DataError> {
    let mut commands = recording.clone();
    of_tendons(&mut commands, file, &model.drive_gains(), model.robot.tendons.angles_deg.len())?;
    // What was measured is not simulated: points of the recording are no stations.
    commands.points = Vec::new();
    let robot = scene_robot(model);
    let options = SimulationOptions { at_rest, ..SimulationOptions::default() };
    let simulated = simulate_recording(&tracked_at_stations(model, &robot), &commands, &options);
    let times_s = times_s(recording, at_rest);
    let tensions: Vec<&[f64]> = (1..=robot.tendons.len())
        .map(|tendon| numbers(&simulated, &format!("tension_{tendon}_n")))
        .collect();
    let frame = |row: usize| {
        let tip_m = simulated.tip_m.as_ref().map(|tips| tips[row]).filter(is_finite);
        let poses = simulated.points.iter().map(|point| {
            let quaternion = point.quaternion.as_ref().map_or([1.0, 0.0, 0.0, 0.0], |all| all[row]);
            StationPose::new(point.position_m[row], quaternion)
        });
        let frame = SceneFrame {
            time_s: times_s[row],
            tip_m,
            poses: if tip_m.is_some() { poses.collect() } else { Vec::new() },
            tensions_n: if tip_m.is_some() {
                tensions.iter().map(|all| all.get(row).copied().unwrap_or(0.0)).collect()
            } else {
                Vec::new()
            },
            target_m: None,
            measured_m: measured_m(recording, row),
        };
        frame.finite()
    };
    let frames = (0..recording.len()).map(frame).collect();
    Ok(Scene { name: name.to_owned(), robot, frames })
}

/// What was measured alone, where there is no model of the robot.
pub fn scene_of_measurement(name: &str, recording: &Recording, at_rest: bool) -> Scene {
    let times_s = times_s(recording, at_rest);
    let frame = |row: usize| {
        let measured_m = measured_m(recording, row);
        SceneFrame { time_s: times_s[row], measured_m, ..SceneFrame::default() }.finite()
    };
    let reach_m = recording.tip_m.iter().flatten().filter(|tip_m| is_finite(tip_m));
    let length_m = reach_m.map(|tip_m| Point3::map(*tip_m, |x| x * x).iter().sum::<f64>().sqrt());
    let robot = SceneRobot {
        length_m: length_m.fold(0.0, f64::max),
        up: [1.0, 0.0, 0.0],
        ..SceneRobot::default()
    };
    let frames = (0..recording.len()).map(frame).collect();
    Scene { name: name.to_owned(), robot, frames }
}

/// Measured tip and points of a row.
fn measured_m(recording: &Recording, row: usize) -> Vec<Point3> {
    let tip_m = recording.tip_m.iter().map(|tips| tips[row]);
    tip_m.chain(recording.points.iter().map(|point| point.position_m[row])).collect()
}

/// Time of each row on one clock: a trial begins a step after the end of the one before.
fn times_s(recording: &Recording, at_rest: bool) -> Vec<f64> {
    if at_rest {
        return (0..recording.len()).map(|row| row as f64).collect();
    }
    let mut times_s = vec![0.0; recording.len()];
    let mut start_s = 0.0;
    for (_, rows) in recording.trials() {
        let own_s = &recording.time_s[rows.clone()];
        let step_s = own_s.get(1).map_or(0.2, |second| second - own_s[0]);
        for (row, time_s) in rows.zip(own_s) {
            times_s[row] = start_s + time_s;
        }
        start_s += own_s.last().copied().unwrap_or(0.0) + step_s;
    }
    times_s
}

/// The numbers of a computed column.
fn numbers<'a>(simulated: &'a Recording, column: &str) -> &'a [f64] {
    match simulated.extra.iter().find(|(name, _)| name == column) {
        Some((_, Extra::Numbers(numbers))) => numbers,
        _ => &[],
    }
}

fn is_finite(point: &Point3) -> bool {
    point.iter().all(|x| x.is_finite())
}
