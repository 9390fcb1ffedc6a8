//! `spinebench collect`.

use super::simulate::{failures, same_tendons};
use super::{Ended, Outcome};
use clap::Args;
use spinebench::base::Seed;
use spinebench::data::Recording;
use spinebench::specs::{PlantSpec, read_plant};
use spinebench::tasks::{PlayOptions, play};
use std::path::PathBuf;

/// Plays commands on a plant and records what its tracker measures.
#[derive(Args)]
pub(super) struct Collect {
    /// Plant file, such as `simulated: {model: real.yaml, noise_m: 0.0005}`.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
    /// Commands: a recording, whose tip columns may be missing; CSV or Parquet.
    #[arg(long, value_name = "IN.csv")]
    commands: PathBuf,
    /// Recording to write; CSV or Parquet.
    #[arg(long, value_name = "REC.csv")]
    out: PathBuf,
    /// Seed of the measurement noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Every row is measured once the robot has come to rest under its command.
    #[arg(long = "static")]
    at_rest: bool,
}

impl Collect {
    pub(super) fn carry_out(self) -> Outcome {
        let plant = read_plant(&self.plant).map_err(Ended::bad)?;
        let PlantSpec::Simulated(plant) = plant else {
            let file = self.plant.display();
            return Err(Ended::BadInput(format!(
                "{file}: found constant_curvature, expected a plant that records: simulated"
            )));
        };
        let commands = Recording::read_commands(&self.commands).map_err(Ended::bad)?;
        same_tendons(&self.commands, &commands, plant.model.robot.tendons.angles_deg.len())?;
        let options = PlayOptions {
            at_rest: self.at_rest,
            noise_m: plant.noise_m,
            travel_m: plant.travel_m,
            seed: Seed(self.seed),
        };
        let mut recorded = play(&plant.model, &commands, &options);
        let failed = failures(&recorded);
        // A tracker sees the tip; what only the simulation knows stays out of a measurement.
        recorded.extra.clone_from(&commands.extra);
        recorded.tip_quaternion = None;
        recorded.write(&self.out).map_err(Ended::bad)?;
        if failed > 0 {
            let (all, out) = (recorded.len(), self.out.display());
            eprintln!("note: {failed} of {all} rows could not be measured; they have valid = 0 in {out}");
        }
        Ok(())
    }
}
