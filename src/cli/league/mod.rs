//! Commands of the league.

mod answer;
mod board;
mod check;
mod common;
mod confine;
mod places;
mod robots;
mod score;
mod season;
mod tried;

use super::CommandResult;
use clap::{Args, Subcommand};
use spinebench::runner::Progress;

/// Check and score controllers and diagnoses on robots with hidden effects, and compare scores on a
/// board (docs/guide/league.md).
#[derive(Args)]
pub(super) struct LeagueCommand {
    #[command(subcommand)]
    command: LeagueTask,
}

#[derive(Subcommand)]
enum LeagueTask {
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
            LeagueTask::Check(check) => check.execute(),
            LeagueTask::Score(score) => score.execute(progress),
            LeagueTask::Table(table) => table.execute(),
            LeagueTask::Robots(robots) => robots.execute(),
            LeagueTask::NewSeason(season) => season.execute(),
            LeagueTask::Seal(seal) => seal.execute(),
            LeagueTask::Open(open) => open.execute(),
            LeagueTask::Confine(confine) => confine.execute(),
            LeagueTask::Answer(answer) => answer.execute(),
        }
    }
}
