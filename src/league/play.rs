//! A submission, or policies of this program, on the robots of a track.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::LeagueError;
use super::instance::{Player, experiment};
use super::robot::LeagueRobot;
use super::score::{CellScore, RobotScore, ScoredTrial};
use super::track::ReadTrack;
use crate::data::write_atomic;
use crate::report::Published;
use crate::rows::cell::Outcome;
use crate::runner::{Campaign, Progress, RunOptions, Store, execute};
use crate::specs::ExperimentSet;

/// How trials are run.
#[derive(Clone, Copy)]
pub struct PlayOptions<'a> {
    /// Stored results; those of a submitted policy are computed anew.
    pub store: &'a Store,
    /// Threads; 0: one for each processor.
    pub threads: usize,
    /// Where progress is shown.
    pub progress: &'a Progress,
    /// Folder in which the experiments are written, a file a robot.
    pub specs: &'a Path,
}

/// What each policy of a player reached on each robot, by its name, the robots in their order.
///
/// # Errors
/// [`LeagueError`] for an experiment that is refused, and where results cannot be stored.
pub fn play(
    read: &ReadTrack,
    robots: &[LeagueRobot],
    player: &Player,
    options: &PlayOptions,
) -> Result<BTreeMap<String, Vec<RobotScore>>, LeagueError> {
    let files = write_experiments(read, robots, player, options.specs)?;
    let experiments = files.iter().map(|file| ExperimentSet::read(file, &[], &[]));
    let experiments: Vec<ExperimentSet> =
        experiments.collect::<Result<_, _>>().map_err(|error| {
            LeagueError::input(format!("{}: experiment: {error}", read.file.display()))
        })?;
    let campaign = Campaign::expand(experiments).map_err(LeagueError::input)?;
    let run = RunOptions::new(options.threads, options.progress);
    let outcomes = execute(&campaign.graph, options.store, &campaign.wanted(), &run)
        .map_err(LeagueError::failed)?;
    let mut scores: BTreeMap<String, Vec<RobotScore>> = BTreeMap::new();
    for (entry, robot) in campaign.entries.iter().zip(robots) {
        for tables in entry.tables(&outcomes) {
            refuse_lost_robot(&tables.published)
                .map_err(|status| LeagueError::failed(format!("{}: {status}", robot.name)))?;
            for (policy, cells) in cells(&tables.published, robot.length_m()) {
                scores.entry(policy).or_default().push(RobotScore::of(robot, cells));
            }
        }
    }
    Ok(scores)
}

/// Writes the experiment of a player on each robot, a file a robot, and returns the files.
///
/// # Errors
/// [`LeagueError::Failed`] where a file cannot be written.
pub fn write_experiments(
    read: &ReadTrack,
    robots: &[LeagueRobot],
    player: &Player,
    folder: &Path,
) -> Result<Vec<PathBuf>, LeagueError> {
    std::fs::create_dir_all(folder).map_err(LeagueError::failed)?;
    let write = |robot: &LeagueRobot| {
        let file = folder.join(format!("{}.yaml", robot.name));
        let text = experiment(read, robot, player)?;
        write_atomic(&file, text.as_bytes()).map_err(LeagueError::failed)?;
        Ok(file)
    };
    robots.iter().map(write).collect()
}

/// The status of a trial whose robot could not be played: the policy is not at fault.
fn refuse_lost_robot(published: &Published) -> Result<(), String> {
    let reached = published.trials.iter().map(|row| &row.value.status);
    let paced = published.paces.iter().map(|row| &row.value.status);
    let mut statuses = reached.chain(paced).map(Outcome::as_str);
    let is_lost = |status: &&str| {
        // As `PlantError::Server` has it, behind the name of a stage that failed before the trials.
        let is_server = |words: &str| words.starts_with("robot server: ");
        is_server(status) || status.split_once(": ").is_some_and(|(_, words)| is_server(words))
    };
    statuses.find(is_lost).map_or(Ok(()), |status| Err(status.to_owned()))
}

/// Trials by policy and mode or speed.
type Trials = BTreeMap<(String, String), Vec<ScoredTrial>>;

/// The cells of each policy: errors over the length of the robot.
fn cells(published: &Published, length_m: f64) -> BTreeMap<String, Vec<CellScore>> {
    let mut trials = Trials::new();
    let mut add = |policy: &str, cell: String, error_m: f64, status: &Outcome| {
        let failure = (!status.is_ok()).then(|| status.as_str().to_owned());
        let key = (policy.to_owned(), cell);
        trials.entry(key).or_default().push((error_m / length_m, failure));
    };
    for row in &published.trials {
        add(&row.cell.policy, row.cell.mode.clone(), row.value.error_m, &row.value.status);
    }
    for row in &published.paces {
        add(
            &row.cell.policy,
            format!("speed {}", row.value.speed),
            row.value.rms_m,
            &row.value.status,
        );
    }
    let mut cells: BTreeMap<String, Vec<CellScore>> = BTreeMap::new();
    for ((policy, cell), trials) in trials {
        cells.entry(policy).or_default().push(CellScore::of(cell, &trials));
    }
    cells
}

/// Adds the error of the best controller of the floor to each cell of `scores`.
///
/// # Errors
/// As [`play`].
pub fn add_floors(
    scores: &mut [RobotScore],
    read: &ReadTrack,
    robots: &[LeagueRobot],
    options: &PlayOptions,
) -> Result<(), LeagueError> {
    if read.track.floor.is_empty() {
        return Ok(());
    }
    let floors = play(read, robots, &Player::Floor, options)?;
    for score in scores {
        for cell in &mut score.cells {
            let same = floors.values().flatten().filter(|floor| floor.robot == score.robot);
            let errors =
                same.flat_map(|floor| &floor.cells).filter(|floor| floor.cell == cell.cell);
            cell.floor = errors.map(|floor| floor.error).reduce(f64::min);
        }
    }
    Ok(())
}
