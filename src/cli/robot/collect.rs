//! `spinebench collect`.

use super::session::{RecordedPlant, RecordingSession};
use crate::cli::models::simulate::{failures, nothing_solved, written};
use crate::cli::program::outputs::check_measured;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::base::Seed;
use spinebench::data::{Actuation, Recording};
use spinebench::plants::hardware::{DryRun, HardwareOptions, RefusedRow, dry_run};
use spinebench::runner::Progress;
use spinebench::specs::{PlantSpec, SimulatedSpec, read_plant};
use spinebench::tasks::{
    SimulationOptions, check_one_gravity, of_tendons, record_trial, simulate_recording, step_s,
};
use std::path::{Path, PathBuf};

/// Execute commands on a plant and record the tracker's measurements.
#[derive(Args)]
pub(crate) struct CollectCommand {
    /// Plant file, such as `simulated: {model: real.yaml, noise_m: 0.0005}`.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
    /// Commands: a recording, whose tip columns may be missing (CSV or Parquet).
    #[arg(long, value_name = "IN.csv")]
    commands: PathBuf,
    /// Recording to write (CSV or Parquet).
    #[arg(long, value_name = "REC.csv", required_unless_present = "dry_run")]
    out: Option<PathBuf>,
    /// Seed of the measurement noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Measure every row when the robot is at rest under its command.
    #[arg(long = "static")]
    at_rest: bool,
    /// Check the commands against the limits of a `hardware` plant and print a summary; no device
    /// is opened or moved.
    #[arg(long)]
    dry_run: bool,
}

impl CollectCommand {
    pub(crate) fn execute(self, progress: &Progress) -> CommandResult {
        let plant = read_plant(&self.plant).map_err(CommandError::bad_input)?;
        let read =
            if self.at_rest { Recording::read_pose_commands } else { Recording::read_commands };
        let mut commands = read(&self.commands).map_err(CommandError::bad_input)?;
        of_tendons(&mut commands, &self.commands, &plant.drive_gains(), plant.tendons())
            .map_err(CommandError::bad_input)?;
        match plant {
            PlantSpec::Simulated(plant) if !self.dry_run => {
                self.simulate(&plant, &commands, progress)
            }
            other => self.record(&other, &commands, progress),
        }
    }

    /// A simulated robot is solved as accurately as in `simulate`, at the times of the commands.
    fn simulate(
        &self,
        plant: &SimulatedSpec,
        commands: &Recording,
        progress: &Progress,
    ) -> CommandResult {
        let out = self.out()?;
        check_one_gravity(&self.commands, commands, &plant.model)
            .map_err(CommandError::bad_input)?;
        commands
            .check_points(&self.commands, &plant.model.tracking.names())
            .map_err(CommandError::bad_input)?;
        check_measured(out, commands)?;
        commands
            .check_travel(&self.commands, plant.model.robot.backbone.length_m)
            .map_err(CommandError::bad_input)?;
        let options = SimulationOptions {
            at_rest: self.at_rest,
            noise_m: plant.noise_m,
            travel_m: plant.travel_m,
            seed: Seed(self.seed),
        };
        progress.step("simulating");
        let mut recorded = simulate_recording(&plant.model, commands, &options);
        progress.done();
        if let Some(words) = plant.model.tracking.starts.told() {
            progress.notice(words);
        }
        let failed = failures(&recorded);
        // The tracker measures positions; what only the simulation knows is left out.
        recorded.extra.clone_from(&commands.extra);
        recorded.forget_orientations();
        recorded.write(out).map_err(CommandError::bad_input)?;
        if failed == recorded.len() && failed > 0 {
            return Err(nothing_solved(&self.plant, &plant.model, out, &recorded));
        }
        if failed > 0 {
            let (all, out) = (recorded.len(), out.display());
            progress.notice(&format!(
                "{failed} of {all} rows could not be measured; they have valid = 0 in {out}"
            ));
        }
        progress.say(&written(out, &recorded));
        Ok(())
    }

    /// Any other plant is driven trial by trial.
    fn record(
        &self,
        plant: &PlantSpec,
        commands: &Recording,
        progress: &Progress,
    ) -> CommandResult {
        let file = self.commands.display();
        if self.at_rest {
            let kind = plant.kind();
            refuse!("--static: found a {kind} plant, expected a simulated one");
        }
        if commands.actuation != Actuation::Lengths {
            refuse!("{file}, line 1: found tensions, expected displacements (tendon_1_m…)");
        }
        if commands.gravity_m_s2.is_some() {
            refuse!(
                "{file}, line 1: found a gravity (gravity_x_m_s2…), expected none: only a \
                 simulated plant has one"
            );
        }
        if commands.tip_load.is_some() {
            refuse!(
                "{file}, line 1: found loads on the tip (tip_force_x_n…), expected none: only a \
                 simulated plant has them"
            );
        }
        let step_s =
            step_s(commands).map_err(|error| CommandError::BadInput(format!("{file}: {error}")))?;
        let summary = match plant {
            PlantSpec::Hardware(options) => Some(self.check_limits(options, commands, step_s)?),
            _ => None,
        };
        if self.dry_run {
            let (PlantSpec::Hardware(options), Some(summary)) = (plant, summary) else {
                let kind = plant.kind();
                refuse!("--dry-run: found a {kind} plant, expected `hardware`");
            };
            print_summary(&summary, options, commands, step_s);
            return Ok(());
        }
        let session = RecordingSession::open(self.out()?, commands)?;
        let mut robot = RecordedPlant::open(plant, step_s, Seed(0))?;
        let recorded = session.record_missing(&mut robot, Seed(self.seed), &record_trial)?;
        progress.say(&written(self.out()?, &recorded));
        Ok(())
    }

    /// Summary of the commands; a command that the robot would refuse is an error before anything
    /// is opened.
    fn check_limits(
        &self,
        options: &HardwareOptions,
        commands: &Recording,
        step_s: f64,
    ) -> Result<DryRun, CommandError> {
        dry_run(&options.safety, commands, step_s).map_err(|RefusedRow { row, refusal }| {
            CommandError::BadInput(format!(
                "{}, line {}: {refusal}",
                self.commands.display(),
                row + 2
            ))
        })
    }

    fn out(&self) -> Result<&Path, CommandError> {
        self.out.as_deref().ok_or_else(|| {
            CommandError::BadInput(
                "--out: found no value, expected the name of the recording to write".into(),
            )
        })
    }
}

/// Prints the summary of a dry run.
fn print_summary(summary: &DryRun, options: &HardwareOptions, commands: &Recording, step_s: f64) {
    let DryRun {
        trials,
        commands: count,
        ticks,
        largest_step_m,
        largest_row,
        reach_m: [low_m, high_m],
    } = summary;
    let duration_s = *ticks as f64 * step_s + *trials as f64 * options.settle_s;
    println!("trials: {trials}, commands: {count}, ticks of {step_s} s: {ticks}");
    println!("duration: {:.1} minutes, without homing and returning home", duration_s / 60.0);
    println!(
        "largest step: {:.3} mm (line {}), at most {:.3} mm per tick",
        largest_step_m * 1e3,
        largest_row + 2,
        options.safety.step_m(step_s) * 1e3
    );
    println!(
        "displacements: {:.3} to {:.3} mm, permitted ±{:.3} mm",
        low_m * 1e3,
        high_m * 1e3,
        options.safety.travel_m * 1e3
    );
    if let Some(loads) = &commands.known_load_kg {
        let hung: Vec<String> = commands
            .trials()
            .iter()
            .map(|(trial, rows)| format!("trial {trial}: {:.1} g", loads[rows.start] * 1e3))
            .collect();
        println!("weights on the tip: {}", hung.join(", "));
    }
    println!("all commands are within the limits; nothing was opened or moved");
}
