//! Commands of the league.

mod answer;
mod board;
mod check;
mod common;
mod confine;
mod robots;
mod score;
mod season;

use super::CommandResult;
use clap::{Args, Subcommand};
use spinebench::runner::Progress;

/// Check and score controllers and diagnoses on robots with hidden effects, and compare scores on a
/// board (docs/guide/league.md).
#[derive(Args)]
pub(super) struct LeagueCommand {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Check(check::CheckCommand),
    Score(score::ScoreCommand),
    Table(board::TableCommand),
    Robots(robots::RobotsCommand),
    NewSeason(season::NewSeasonCommand),
    Seal(season::SealCommand),
    Open(season::OpenCommand),
    #[command(hide = true)]
    Confine(confine::ConfineCommand),
    #[command(hide = true)]
    Answer(answer::AnswerCommand),
}

impl LeagueCommand {
    pub(super) fn execute(self, progress: &Progress) -> CommandResult {
        match self.command {
            Command::Check(check) => check.execute(),
            Command::Score(score) => score.execute(progress),
            Command::Table(table) => table.execute(),
            Command::Robots(robots) => robots.execute(),
            Command::NewSeason(season) => season.execute(),
            Command::Seal(seal) => seal.execute(),
            Command::Open(open) => open.execute(),
            Command::Confine(confine) => confine.execute(),
            Command::Answer(answer) => answer.execute(),
        }
    }
}
