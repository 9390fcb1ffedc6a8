//! The commands. Exit status 0: done; 1: ran, and the answer is no; 2: bad input or usage, nothing
//! written.

/// Ends a command with bad input, in words as of `format!`.
macro_rules! refuse {
    ($($words:tt)*) => {
        return Err($crate::cli::CommandError::BadInput(format!($($words)*)))
    };
}

mod experiments;
mod league;
mod models;
mod program;
mod robot;
mod viewer;

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use std::sync::Arc;

/// Test learning-based controllers of continuum robots, and find what a simulator lacks.
#[derive(Parser)]
#[command(name = "spinebench", version = spinebench::VERSION, propagate_version = true)]
struct Arguments {
    #[command(flatten)]
    reporting: program::shared::ReportingArgs,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(experiments::run::RunCommand),
    Cache(experiments::cache::CacheCommand),
    Plan(experiments::plan::PlanCommand),
    Simulate(models::simulate::SimulateCommand),
    View(viewer::command::ViewCommand),
    Calibrate(models::calibrate::CalibrateCommand),
    Effects(models::effects::EffectsCommand),
    Discover(models::discover::DiscoverCommand),
    Collect(robot::collect::CollectCommand),
    Doctor(robot::doctor::DoctorCommand),
    Arm(robot::arm::ArmCommand),
    Align(robot::align::AlignCommand),
    Weigh(robot::weigh::WeighCommand),
    Rehearse(robot::rehearse::RehearseCommand),
    Import(models::import::ImportCommand),
    Export(models::export::ExportCommand),
    Pack(experiments::pack::PackCommand),
    Plot(experiments::plot::PlotCommand),
    Page(experiments::page::PageCommand),
    Schema(program::schema::SchemaCommand),
    Completions(program::completions::CompletionsCommand),
    Gather(experiments::gather::GatherCommand),
    Verify(experiments::verify::VerifyCommand),
    Compare(experiments::compare::CompareCommand),
    Report(experiments::report::ReportCommand),
    League(league::LeagueCommand),
    Status(experiments::cluster::StatusCommand),
    Cancel(experiments::cluster::CancelCommand),
    #[command(hide = true)]
    Work(experiments::cluster::WorkCommand),
}

/// Why a command ends with an exit status other than 0.
pub(crate) enum CommandError {
    /// It ran and its answer is no, or its results could not be written: exit status 1.
    Failed(String),
    /// It ran, has printed its answer, and that is no: exit status 1.
    Answered,
    /// Bad input or usage: exit status 2.
    BadInput(String),
}

impl CommandError {
    /// Bad input, with the message of `error`.
    pub(crate) fn bad_input(error: impl std::fmt::Display) -> CommandError {
        CommandError::BadInput(error.to_string())
    }

    /// A failed run, with the message of `error`.
    pub(crate) fn failed(error: impl std::fmt::Display) -> CommandError {
        CommandError::Failed(error.to_string())
    }
}

/// What a command returns.
pub(crate) type CommandResult = Result<(), CommandError>;

/// Parses the arguments and executes the command.
pub(crate) fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let progress = Arc::new(arguments.reporting.progress());
    let outcome = match arguments.command {
        Command::Run(run) => run.execute(&progress),
        Command::Cache(cache) => cache.execute(),
        Command::Plan(plan) => plan.execute(),
        Command::Simulate(simulate) => simulate.execute(&progress),
        Command::View(view) => view.execute(&progress),
        Command::Calibrate(calibrate) => calibrate.execute(&progress),
        Command::Effects(effects) => effects.execute(),
        Command::Discover(discover) => discover.execute(&progress),
        Command::Collect(collect) => collect.execute(&progress),
        Command::Doctor(doctor) => doctor.execute(),
        Command::Arm(arm) => arm.execute(),
        Command::Align(align) => align.execute(),
        Command::Weigh(weigh) => weigh.execute(&progress),
        Command::Rehearse(rehearse) => rehearse.execute(),
        Command::Import(import) => import.execute(&progress),
        Command::Export(export) => export.execute(&progress),
        Command::Pack(pack) => pack.execute(),
        Command::Plot(plot) => plot.execute(&progress),
        Command::Page(page) => page.execute(),
        Command::Schema(schema) => schema.execute(),
        Command::Completions(completions) => completions.execute(),
        Command::Gather(gather) => gather.execute(&progress),
        Command::Compare(compare) => compare.execute(),
        Command::Report(report) => report.execute(),
        Command::League(league) => league.execute(&progress),
        Command::Verify(verify) => verify.execute(&progress),
        Command::Status(status) => status.execute(),
        Command::Cancel(cancel) => cancel.execute(),
        Command::Work(work) => work.execute(&progress),
    };
    let (message, status) = match outcome {
        Ok(()) => return ExitCode::SUCCESS,
        Err(CommandError::Answered) => return ExitCode::from(1),
        Err(CommandError::Failed(message)) => (message, 1),
        Err(CommandError::BadInput(message)) => (message, 2),
    };
    eprintln!("error: {message}");
    ExitCode::from(status)
}
