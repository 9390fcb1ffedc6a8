//! The commands. Exit status 0: done; 1: ran, and the answer is no; 2: bad input or usage, and nothing was written.

mod align;
mod arm;
mod cache;
mod calibrate;
mod cluster;
mod collect;
mod completions;
mod discover;
mod doctor;
mod effects;
mod gather;
mod import;
mod page;
mod plan;
mod rehearse;
mod run;
mod schema;
mod session;
mod shared;
mod simulate;
mod verify;
mod weigh;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Does this learning-based continuum-robot controller really work, and where is my simulator wrong?
#[derive(Parser)]
#[command(name = "spinebench", version, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(run::Run),
    Cache(cache::CacheCommand),
    Plan(plan::Plan),
    Simulate(simulate::Simulate),
    Calibrate(calibrate::Calibrate),
    Effects(effects::Effects),
    Discover(discover::Discover),
    Collect(collect::Collect),
    Doctor(doctor::Doctor),
    Arm(arm::Arm),
    Align(align::Align),
    Weigh(weigh::Weigh),
    Rehearse(rehearse::Rehearse),
    Import(import::Import),
    Page(page::Page),
    Schema(schema::Schema),
    Completions(completions::Completions),
    Gather(gather::Gather),
    Verify(verify::Verify),
    Status(cluster::Status),
    Cancel(cluster::Cancel),
    #[command(hide = true)]
    Work(cluster::Work),
}

/// How a command that did not succeed ends.
pub(crate) enum Ended {
    /// It ran, and the answer is no, or what it found could not be written: exit status 1.
    No(String),
    /// Bad input or usage: exit status 2.
    BadInput(String),
}

impl Ended {
    /// Bad input, in the words of the error.
    pub(crate) fn bad(error: impl std::fmt::Display) -> Ended {
        Ended::BadInput(error.to_string())
    }

    /// It ran and failed, in the words of the error.
    pub(crate) fn failed(error: impl std::fmt::Display) -> Ended {
        Ended::No(error.to_string())
    }
}

/// What a command returns.
pub(crate) type Outcome = Result<(), Ended>;

/// Parses the arguments and carries out the command.
pub(crate) fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Run(run) => run.carry_out(),
        Command::Cache(cache) => cache.carry_out(),
        Command::Plan(plan) => plan.carry_out(),
        Command::Simulate(simulate) => simulate.carry_out(),
        Command::Calibrate(calibrate) => calibrate.carry_out(),
        Command::Effects(effects) => effects.carry_out(),
        Command::Discover(discover) => discover.carry_out(),
        Command::Collect(collect) => collect.carry_out(),
        Command::Doctor(doctor) => doctor.carry_out(),
        Command::Arm(arm) => arm.carry_out(),
        Command::Align(align) => align.carry_out(),
        Command::Weigh(weigh) => weigh.carry_out(),
        Command::Rehearse(rehearse) => rehearse.carry_out(),
        Command::Import(import) => import.carry_out(),
        Command::Page(page) => page.carry_out(),
        Command::Schema(schema) => schema.carry_out(),
        Command::Completions(completions) => completions.carry_out(),
        Command::Gather(gather) => gather.carry_out(),
        Command::Verify(verify) => verify.carry_out(),
        Command::Status(status) => status.carry_out(),
        Command::Cancel(cancel) => cancel.carry_out(),
        Command::Work(work) => work.carry_out(),
    };
    let (words, status) = match outcome {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Ended::No(words)) => (words, 1),
        Err(Ended::BadInput(words)) => (words, 2),
    };
    eprintln!("error: {words}");
    ExitCode::from(status)
}
