//! `spinebench weigh`.

use super::session::{RecordedPlant, RecordingSession, read_hardware_plant};
use crate::cli::models::simulate::written;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::base::Seed;
use spinebench::data::{Actuation, Recording};
use spinebench::plants::hardware::HardwareOptions;
use spinebench::runner::Progress;
use spinebench::tasks::{
    StaticPoseOptions, of_tendons, plan_static_poses, record_static_poses, star_m,
};
use std::path::PathBuf;

/// Control step of the session, s.
pub(crate) const STEP_S: f64 = 0.2;

/// Record the robot at rest in several poses under each of several weights, for `spinebench
/// calibrate --static`.
///
/// Asks the operator to hang each weight on the tip. The same command resumes an interrupted
/// recording. In a rehearsal the weights are added to the simulated robot without a prompt.
#[derive(Args)]
pub(crate) struct WeighCommand {
    /// Plant file with `hardware:`.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
    /// Weights in the order in which they are hung on the tip, kilograms; 0 is none.
    #[arg(long, value_name = "KG,…", value_delimiter = ',', default_value = "0,0.01,0.02", value_parser = kilograms)]
    weights: Vec<f64>,
    /// Recording to write (CSV or Parquet).
    #[arg(long, value_name = "REC.csv")]
    out: PathBuf,
    /// Commands with one pose per row [default: home, and bent in eight directions].
    #[arg(long, value_name = "POSES.csv")]
    poses: Option<PathBuf>,
    /// Tendon displacement of the default poses, metres.
    #[arg(long, value_name = "M", default_value_t = 0.012)]
    reach_m: f64,
    /// Steps of 0.2 s during which the robot comes to rest in each pose.
    #[arg(long, value_name = "N", default_value_t = StaticPoseOptions::default().rest_steps)]
    rest_steps: usize,
    /// Do not prompt the operator: each weight is attached before its trials begin.
    #[arg(long)]
    yes: bool,
}

fn kilograms(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|load_kg: &f64| (0.0..=10.0).contains(load_kg));
    number.ok_or_else(|| format!("found `{text}`, expected 0 to 10 kg"))
}

impl WeighCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let options = read_hardware_plant(&self.plant)?;
        let visiting = visiting(&options, self.rest_steps);
        let poses_m = self.poses_m(&options)?;
        let planned = plan_static_poses(&poses_m, &self.weights, &visiting, STEP_S);
        let mut session = RecordingSession::open(&self.out, &planned)?;
        session.assume_done = self.yes;
        let mut robot = RecordedPlant::open_hardware(&options, STEP_S, Seed(1))?;
        let (poses, minutes) = (poses_m.len(), minutes(&planned));
        eprintln!(
            "note: {poses} poses with each of {} weights, about {minutes:.0} minutes",
            self.weights.len()
        );
        let recorded =
            session.record_missing(&mut robot, Seed(1), &|plant, planned, rows, seed| {
                record_static_poses(plant, planned, rows, &visiting, seed)
            })?;
        progress.say(&written(&self.out, &recorded));
        println!(
            "next: spinebench calibrate --static --model MODEL.yaml --measured {} --out \
             CALIBRATED.yaml",
            self.out.display()
        );
        Ok(())
    }

    fn poses_m(&self, options: &HardwareOptions) -> Result<Vec<Vec<f64>>, CommandError> {
        let Some(file) = &self.poses else { return star(self.reach_m, options) };
        let mut commands = Recording::read_commands(file).map_err(CommandError::bad_input)?;
        of_tendons(&mut commands, file, &options.model.drive_gains(), 4)
            .map_err(CommandError::bad_input)?;
        if commands.actuation != Actuation::Lengths {
            refuse!(
                "{}, line 1: found tensions, expected displacements (tendon_1_m…)",
                file.display()
            );
        }
        let poses_m: Vec<Vec<f64>> = commands.commands.iter().map(<[f64]>::to_vec).collect();
        for (row, pose) in poses_m.iter().enumerate() {
            // The way from home keeps to the step limit; only the pose itself may be out of range.
            options.safety.check_command(pose, &[0.0; 4], f64::INFINITY, usize::MAX).map_err(
                |refusal| {
                    CommandError::BadInput(format!(
                        "{}, line {}: {refusal}",
                        file.display(),
                        row + 2
                    ))
                },
            )?;
        }
        Ok(poses_m)
    }
}

/// Options for visiting poses within the limits of a robot.
pub(crate) fn visiting(options: &HardwareOptions, rest_steps: usize) -> StaticPoseOptions {
    StaticPoseOptions {
        max_step_m: options.safety.step_m(STEP_S),
        rest_steps,
        ..StaticPoseOptions::default()
    }
}

/// Home, and bent by `reach_m` in eight directions, within the travel of a robot.
pub(crate) fn star(reach_m: f64, options: &HardwareOptions) -> Result<Vec<Vec<f64>>, CommandError> {
    let travel_m = options.safety.travel_m;
    if !(reach_m > 0.0 && reach_m <= travel_m) {
        refuse!("--reach-m: found {reach_m}, expected more than 0 and at most {travel_m}");
    }
    Ok(star_m(reach_m))
}

fn minutes(planned: &Recording) -> f64 {
    planned.trials().iter().map(|(_, rows)| planned.time_s[rows.end - 1]).sum::<f64>() / 60.0
}
