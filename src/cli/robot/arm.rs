//! `spinebench arm`.

use super::session::read_hardware_plant;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::hardware::safety::Latch;
use std::path::PathBuf;

/// Arm a robot that was stopped, after a person has inspected it.
#[derive(Args)]
pub(crate) struct ArmCommand {
    /// Plant file with `hardware:`.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
}

impl ArmCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let options = read_hardware_plant(&self.plant)?;
        let latch = Latch::new(&Latch::folder(), &options.name);
        match latch.release().map_err(CommandError::failed)? {
            Some(reason) => {
                println!("armed: `{}` was stopped {reason}", options.name);
                println!("steps may have been lost: the robot is homed before its next motion");
            }
            None => println!("`{}` was not stopped", options.name),
        }
        Ok(())
    }
}
