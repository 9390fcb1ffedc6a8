//! `spinebench arm`.

use super::{Ended, Outcome};
use clap::Args;
use spinebench::hardware::safety::Latch;
use spinebench::specs::{PlantSpec, read_plant};
use std::path::PathBuf;

/// Lets a robot move again that has been stopped, once somebody has looked at it.
#[derive(Args)]
pub(super) struct Arm {
    /// Plant file of a robot on a bench.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
}

impl Arm {
    pub(super) fn carry_out(self) -> Outcome {
        let PlantSpec::Hardware(options) = read_plant(&self.plant).map_err(Ended::bad)? else {
            return Err(Ended::BadInput(format!("{}: expected `hardware`", self.plant.display())));
        };
        let latch = Latch::new(&Latch::folder(), &options.name);
        match latch.release().map_err(Ended::failed)? {
            Some(reason) => println!("armed: `{}` had been stopped {reason}", options.name),
            None => println!("`{}` was not stopped", options.name),
        }
        Ok(())
    }
}
