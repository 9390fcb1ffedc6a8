//! `spinebench align`.

use super::session::read_hardware_plant;
use super::weigh::{STEP_S, star, visiting};
use crate::cli::program::outputs::check_yaml;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::base::{Point3, Seed};
use spinebench::data::{Recording, write_atomic};
use spinebench::hardware::tracking::{Alignment, RigidPose, realign};
use spinebench::plants::hardware::{Hardware, HardwareOptions};
use spinebench::specs::{PlantSpec, to_yaml};
use spinebench::tasks::{
    SimulationOptions, of_tendons, plan_static_poses, record_static_poses, simulate_recording,
};
use std::path::PathBuf;

/// Steps during which the robot comes to rest in each pose.
const REST_STEPS: usize = 8;
/// Largest residual rms over the rms distance of the points from their centre: above it the points
/// do not correspond to each other.
const MAX_RELATIVE_RESIDUAL: f64 = 0.35;

/// Estimate the pose of the robot's base frame relative to the tracker's base body from measured
/// and predicted tip positions.
///
/// Prints the setting `tracking.alignment` for the plant file, or writes a plant file with it.
/// Model errors bias the result: use a calibrated model and poses in all directions.
#[derive(Args)]
pub(crate) struct AlignCommand {
    /// Plant file with `hardware:`.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
    /// Recording of this robot, measured with the current alignment of the plant file.
    #[arg(
        long,
        value_name = "REC.csv",
        required_unless_present = "moving",
        conflicts_with = "moving"
    )]
    measured: Option<PathBuf>,
    /// Treat every row of the recording as a pose at rest, as `weigh` writes them.
    #[arg(long = "static", conflicts_with = "moving")]
    at_rest: bool,
    /// Measure now instead of reading a recording: home the robot and bend it in eight directions.
    #[arg(long = "move")]
    moving: bool,
    /// Tendon displacement with --move, metres.
    #[arg(long, value_name = "M", default_value_t = 0.012)]
    reach_m: f64,
    /// Plant file to write: all settings of the given file, with the new alignment.
    #[arg(long, value_name = "PLANT2.yaml")]
    out: Option<PathBuf>,
}

impl AlignCommand {
    pub(crate) fn execute(self) -> CommandResult {
        self.out.as_deref().map_or(Ok(()), check_yaml)?;
        let mut options = read_hardware_plant(&self.plant)?;
        let (recording, at_rest) = match &self.measured {
            Some(file) => {
                let mut recording = Recording::read(file).map_err(CommandError::bad_input)?;
                of_tendons(&mut recording, file, &options.model.drive_gains(), 4)
                    .map_err(CommandError::bad_input)?;
                (recording, self.at_rest)
            }
            None => (self.record_poses(&options)?, true),
        };
        let alignment =
            aligned(&options, &recording, at_rest).map_err(|words| match &self.measured {
                Some(file) => CommandError::BadInput(format!("{}: {words}", file.display())),
                None => CommandError::Failed(words),
            })?;
        options.tracking.alignment = alignment.pose;
        print_alignment(&alignment)?;
        if let Some(out) = &self.out {
            let text = to_yaml(&PlantSpec::Hardware(options)).map_err(CommandError::failed)?;
            write_atomic(out, text.as_bytes()).map_err(CommandError::bad_input)?;
        }
        Ok(())
    }

    /// Records poses at rest.
    fn record_poses(&self, options: &HardwareOptions) -> Result<Recording, CommandError> {
        let star_m = star(self.reach_m, options)?;
        // The tip's measured position is what is to be calibrated: it must not hold the robot.
        let mut unaligned = options.clone();
        unaligned.safety.tip_from_model_m = f64::MAX;
        let visiting = visiting(options, REST_STEPS);
        let planned = plan_static_poses(&star_m, &[0.0], &visiting, STEP_S);
        let mut plant =
            Hardware::open(&unaligned, STEP_S, Seed(1)).map_err(CommandError::Failed)?;
        record_static_poses(&mut plant, &planned, 0..planned.len(), &visiting, Seed(1))
            .map_err(CommandError::failed)
    }
}

/// The alignment that brings the measured tips to the predicted ones, or why there is none.
fn aligned(
    options: &HardwareOptions,
    measured: &Recording,
    at_rest: bool,
) -> Result<Alignment, String> {
    let played = simulate_recording(
        &options.model,
        measured,
        &SimulationOptions { at_rest, ..SimulationOptions::default() },
    );
    let (Some(model_m), Some(seen_m)) = (&played.tip_m, &measured.tip_m) else {
        return Err("found no tip".to_owned());
    };
    let finite = |point: &Point3| point.iter().all(|value| value.is_finite());
    let rows = (0..measured.len()).filter(|&row| {
        measured.is_valid(row)
            && played.is_valid(row)
            && finite(&model_m[row])
            && finite(&seen_m[row])
    });
    let (model_m, seen_m): (Vec<Point3>, Vec<Point3>) =
        rows.map(|row| (model_m[row], seen_m[row])).unzip();
    let alignment = realign(&options.tracking.alignment, &model_m, &seen_m)
        .map_err(|fault| fault.to_string())?;
    if alignment.residual_m <= MAX_RELATIVE_RESIDUAL * alignment.spread_m {
        return Ok(alignment);
    }
    if alignment.directions_agree() {
        return Ok(Alignment { pose: alignment.straight_pose, ..alignment });
    }
    let (residual_mm, spread_mm) = (alignment.residual_m * 1e3, alignment.spread_m * 1e3);
    Err(format!(
        "no rotation and shift fits the measured tips: residual {residual_mm:.1} mm rms of \
         {spread_mm:.1} mm, {:.2} times the predicted bend, directions {:.0} degrees apart; check \
         tip_body, base_body, up_axis, the order of the tendons, and the model",
        alignment.ratio,
        alignment.apart_rad.to_degrees()
    ))
}

/// Ratios of measured to predicted bends that are not worth a word.
const AS_PREDICTED: [f64; 2] = [0.9, 1.1];

fn print_alignment(alignment: &Alignment) -> CommandResult {
    let Alignment { pose, residual_m, worst_m, turn_rad, .. } = alignment;
    #[derive(serde::Serialize)]
    struct TrackingSection<'a> {
        alignment: &'a RigidPose,
    }
    #[derive(serde::Serialize)]
    struct PlantFragment<'a> {
        tracking: TrackingSection<'a>,
    }
    print!(
        "{}",
        to_yaml(&PlantFragment { tracking: TrackingSection { alignment: pose } })
            .map_err(CommandError::failed)?
    );
    println!(
        "# residual {:.2} mm rms, {:.2} mm at most; rotation ± {:.2} degrees (95 %), if the model \
         is correct",
        residual_m * 1e3,
        worst_m * 1e3,
        turn_rad.to_degrees()
    );
    let Alignment { ratio, apart_rad, .. } = alignment;
    if !(AS_PREDICTED[0]..=AS_PREDICTED[1]).contains(ratio) {
        println!(
            "# the robot bends {ratio:.2} times as far as the model; directions agree within {:.1} \
             degrees rms: calibrate the model (`spinebench calibrate --static`), then align again",
            apart_rad.to_degrees()
        );
    }
    Ok(())
}
