//! `spinebench rehearse`.

mod fault_commands;
mod log;

use super::session::read_hardware_plant;
use crate::cli::program::outputs::check_yaml;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use log::SimulatorLog;
use spinebench::base::Seed;
use spinebench::data::write_atomic;
use spinebench::hardware::interrupt::Interrupt;
use spinebench::hardware::realtime::{Priority, RealTime};
use spinebench::plants::hardware::ServedSimulator;
use spinebench::specs::{PlantSpec, to_yaml};
use std::io::stdin;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};

/// Simulate a robot, its motor controller on a serial port and its tracker on UDP.
///
/// Other commands and programs connect through the plant file that this command writes. Lines on
/// standard input inject faults: `help` lists them. Ctrl-C or `quit` ends the command.
#[derive(Args)]
pub(crate) struct RehearseCommand {
    /// Plant file with `hardware:` and `rehearsal:`.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
    /// Plant file to write, for other commands to use.
    #[arg(long, value_name = "SERVED.yaml")]
    out: PathBuf,
    /// CSV log of all input of the controller and of all starts and stops of the screws.
    #[arg(long, value_name = "LOG.csv")]
    log_file: Option<PathBuf>,
    /// Run with real-time priority, as real devices would (needs CAP_SYS_NICE or `rtprio`).
    #[arg(long, alias = "urgent")]
    real_time: bool,
    /// Seed of noise and losses.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl RehearseCommand {
    pub(crate) fn execute(self) -> CommandResult {
        check_yaml(&self.out)?;
        let options = read_hardware_plant(&self.plant)?;
        if options.rehearsal.is_none() {
            let file = self.plant.display();
            refuse!("{file}: hardware: found no `rehearsal`, expected the model to simulate");
        }
        let interrupt = Interrupt::of_process().map_err(CommandError::failed)?;
        let mut served =
            ServedSimulator::open(&options, Seed(self.seed)).map_err(CommandError::Failed)?;
        let mut log = SimulatorLog::open(self.log_file.as_deref())?;
        let plant = served.plant();
        let text =
            to_yaml(&PlantSpec::Hardware(Box::new(plant.clone()))).map_err(CommandError::failed)?;
        // The ports are open before the file exists: input that arrives before the first step is
        // buffered by the system.
        write_atomic(&self.out, text.as_bytes()).map_err(CommandError::bad_input)?;
        println!(
            "motors at {}, tracker at {}:{}",
            plant.motion.port, plant.tracking.server, plant.tracking.command_port
        );
        println!(
            "try `spinebench doctor --plant {}`; `help` lists the faults that can be injected",
            self.out.display()
        );
        let lines = lines_of_stdin();
        let _priority = self.real_time.then(|| RealTime::new(Priority::Simulator));
        while !interrupt.raised() {
            let now_s = served.step();
            log.record_changes(now_s, served.simulator())?;
            for line in lines.try_iter() {
                match line.trim() {
                    "quit" => return Ok(()),
                    "" => {}
                    text => match fault_commands::parse(text) {
                        Ok(plan) => {
                            plan(served.simulator());
                            log.record_command(now_s, text, served.simulator())?;
                        }
                        Err(words) => println!("{words}"),
                    },
                }
            }
        }
        Ok(())
    }
}

/// Lines from standard input; none after it has ended.
fn lines_of_stdin() -> Receiver<String> {
    let (sender, lines) = channel();
    std::thread::spawn(move || {
        for line in stdin().lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    lines
}
