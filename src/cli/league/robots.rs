//! `spinebench league robots`.

use super::common::{SeasonArgs, engine_faults};
use crate::cli::CommandResult;
use clap::Args;
use spinebench::league::instance::Player;
use spinebench::league::play::write_experiments;
use spinebench::league::questions::{recordings, write_questions};
use std::path::PathBuf;

/// Write the robots of a track: an experiment for each, which `spinebench run` runs, or for a track
/// with questions the recordings to answer.
#[derive(Args)]
pub(crate) struct RobotsCommand {
    /// The track.
    track: String,
    /// Folder to write them in.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    season: SeasonArgs,
}

impl RobotsCommand {
    pub(crate) fn execute(&self) -> CommandResult {
        let robots = self.season.robots()?;
        let (read, drawn) = self.season.track(&self.track, &robots, &[])?;
        if recordings(&read.track.task).is_some() {
            let faults = engine_faults(&drawn);
            if !faults.is_empty() {
                refuse!("{}", faults.join("\n"));
            }
            write_questions(&read, &drawn, &self.out)?;
            if self.season.season.is_some() {
                println!("answers state `questions: {}` in submission.yaml", robots.label());
            }
        } else {
            if robots.are_sealed() {
                refuse!(
                    "--secret: found a track with trials, expected one with questions: its experiments would show the sealed robots"
                );
            }
            let player = Player::Builtin(vec!["integral".to_owned()]);
            write_experiments(&read, &drawn, &player, &self.out)?;
        }
        println!("{} robots of `{}` in {}", drawn.len(), read.name, self.out.display());
        Ok(())
    }
}
