//! Arguments that several commands of the league take.

use crate::cli::CommandError;
use clap::Args;
use spinebench::league::LeagueError;
use spinebench::league::measured::measured_robots;
use spinebench::league::robot::{LeagueRobot, RobotSeed, draw};
use spinebench::league::season::{DEVELOPMENT, PUBLIC_SEED, Season, label};
use spinebench::league::track::ReadTrack;
use spinebench::plants::PlantSpec;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Duration of a control step, seconds: the paper's 5 Hz.
pub(super) const STEP_S: f64 = 0.2;

impl From<LeagueError> for CommandError {
    fn from(error: LeagueError) -> CommandError {
        match error {
            LeagueError::Input(words) => CommandError::BadInput(words),
            LeagueError::Failed(words) => CommandError::Failed(words),
        }
    }
}

/// Which robots play.
#[derive(Args)]
pub(super) struct SeasonArgs {
    /// Folder of the tracks.
    #[arg(long, value_name = "DIR", default_value = "experiments/league")]
    pub(super) tracks: PathBuf,
    /// File of a season. Without it, the development robots.
    #[arg(long, value_name = "SEASON.yaml")]
    pub(super) season: Option<PathBuf>,
    /// File of the season's secret: play its sealed robots. A season that was opened needs none.
    #[arg(long, value_name = "FILE", requires = "season")]
    pub(super) secret: Option<PathBuf>,
    /// Play the sealed robots of a season that was opened.
    #[arg(long, requires = "season")]
    sealed: bool,
    /// Folder of recordings of real robots, as `benches/real/real.py --convert` writes it: they
    /// play too, in a track that has any.
    #[arg(long, value_name = "DIR")]
    pub(super) measured: Option<PathBuf>,
}

/// The season that robots belong to.
pub(super) struct Robots {
    /// Its name.
    pub(super) season: String,
    /// What draws them.
    pub(super) seed: RobotSeed,
    /// Hash of the secret that draws them, where they are sealed.
    pub(super) secret: Option<String>,
}

impl Robots {
    pub(super) fn are_sealed(&self) -> bool {
        self.secret.is_some()
    }

    /// The season as tables and questions name it.
    pub(super) fn label(&self) -> String {
        label(&self.season, self.are_sealed())
    }
}

impl SeasonArgs {
    /// What draws the robots. Tracks and program are those of the season.
    pub(super) fn robots(&self) -> Result<Robots, CommandError> {
        let Some(file) = &self.season else {
            return Ok(Robots {
                season: DEVELOPMENT.to_owned(),
                seed: RobotSeed::Public(PUBLIC_SEED),
                secret: None,
            });
        };
        let season = Season::read(file)?;
        season.check_frozen(file, &self.tracks)?;
        let text = match (&self.secret, &season.secret) {
            (Some(secret), _) => Some(read(secret)?),
            (None, Some(secret)) if self.sealed => Some(secret.clone()),
            (None, None) if self.sealed => refuse!(
                "{}: found no `secret`, expected a season that was opened, or --secret FILE",
                file.display()
            ),
            _ => None,
        };
        let secret = text.map(|text| season.checked(&text)).transpose()?;
        let seed = season.seed(secret);
        Ok(Robots {
            season: season.season,
            seed,
            secret: season.sealed.filter(|_| secret.is_some()),
        })
    }

    /// A track and its robots, of these families alone where there are any.
    pub(super) fn track(
        &self,
        name: &str,
        robots: &Robots,
        families: &[String],
    ) -> Result<(ReadTrack, Vec<LeagueRobot>), CommandError> {
        let read = ReadTrack::read(&self.tracks, name)?;
        let mut drawn = draw(&read, &robots.seed)?;
        if let Some(folder) = &self.measured {
            drawn.extend(measured_robots(&read, folder)?);
        }
        drawn.retain(|robot| families.is_empty() || families.contains(&robot.family));
        Ok((read, drawn))
    }
}

/// The text of the file of a secret.
pub(super) fn read(file: &Path) -> Result<String, CommandError> {
    std::fs::read_to_string(file)
        .map_err(|error| CommandError::BadInput(format!("--secret: {}: {error}", file.display())))
}

/// Engines that cannot be started on this machine: their robots could not be played.
pub(super) fn engine_faults(robots: &[LeagueRobot]) -> Vec<String> {
    let external = robots.iter().filter(|robot| matches!(robot.plant, PlantSpec::External(_)));
    let one_each: BTreeMap<&str, &LeagueRobot> =
        external.map(|robot| (robot.engine.as_str(), robot)).collect();
    let failed = |(engine, robot): (&str, &LeagueRobot)| {
        let error = robot.plant.build(STEP_S).err()?;
        Some(format!(
            "this machine: engine `{engine}`: found {error}, expected a robot that can be played; without MuJoCo: `pip install -r benches/league/requirements.txt`"
        ))
    };
    one_each.into_iter().filter_map(failed).collect()
}
