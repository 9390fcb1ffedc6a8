//! `spinebench arm`.

use super::session::read_hardware_plant;
use super::{CommandError, CommandResult};
use clap::Args;
use spinebench::hardware::safety::Latch;
use std::path::PathBuf;

/// Lets a robot move again that has been stopped, once somebody has looked at it.
#[derive(Args)]
pub(super) struct ArmCommand {
    /// Plant file of a robot on a bench.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
}

impl ArmCommand {
    pub(super) fn execute(self) -> CommandResult {
        let options = read_hardware_plant(&self.plant)?;
        let latch = Latch::new(&Latch::folder(), &options.name);
        match latch.release().map_err(CommandError::failed)? {
            Some(reason) => {
                println!("armed: `{}` had been stopped {reason}", options.name);
                println!("steps may have been lost: it is homed before it moves again");
            }
            None => println!("`{}` was not stopped", options.name),
        }
        Ok(())
    }
}
