//! One task of an array: sees its stages done, and ends in time to be continued.

use super::folder::Folder;
use super::queue;
use crate::hardware::interrupt::Interrupt;
use crate::runner::campaign::Campaign;
use crate::runner::executor::{RunOptions, execute};
use crate::runner::graph::Failure;
use crate::runner::key::Key;
use crate::runner::outcomes::Outcomes;
use crate::runner::progress::Progress;
use crate::specs::ExperimentSet;
use std::collections::HashMap;
use std::time::Duration;

/// Which task.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Number of the attempt, from 1.
    pub attempt: usize,
    /// Number of the wave, from 0.
    pub wave: usize,
    /// Number of the task in its wave.
    pub task: usize,
}

/// What became of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Worked {
    /// Its stages are done or have failed.
    Done,
    /// It was told to end before that and has been put back into the queue.
    Requeued,
}

/// Carries out a task.
///
/// # Errors
/// What the campaign's folder lacks, in words.
pub fn work(folder: &Folder, place: Place, threads: usize, progress: &Progress) -> Result<Worked, String> {
    let attempt = folder.attempt(place.attempt).ok_or_else(|| missing(folder, "attempt"))?;
    let tasks = attempt.waves.get(place.wave).ok_or_else(|| missing(folder, "wave"))?;
    let keys = tasks.get(place.task).ok_or_else(|| missing(folder, "task"))?;
    let campaign = campaign(folder)?;
    let Some(wanted) = numbers(&campaign, keys) else {
        let status =
            "the program, or a recording that it replays, is another here than where it was submitted".to_owned();
        let failure = Failure { stage: "slurm".into(), status: status.clone() };
        keys.iter().try_for_each(|key| folder.put_failure(key, &failure))?;
        return Err(status);
    };
    let notice = Interrupt::of_batch().map_err(|error| error.to_string())?;
    let known = folder.failures();
    let options = RunOptions { threads, progress, stop: notice.flag(), known: &known };
    let outcomes =
        execute(&campaign.graph, &folder.store(), &wanted, &options).map_err(|failure| failure.to_string())?;
    tell_failures(folder, &campaign, &outcomes)?;
    if !outcomes.stopped {
        return Ok(Worked::Done);
    }
    queue::requeue_self()?;
    // The cluster ends this process when it has put the task back.
    std::thread::sleep(Duration::from_secs(60));
    Ok(Worked::Requeued)
}

/// The campaign, expanded from the specs in its folder.
pub(super) fn campaign(folder: &Folder) -> Result<Campaign, String> {
    let read = |file| ExperimentSet::read(file, &[], &[]).map_err(|error| error.to_string());
    let specs = folder.specs().iter().map(|file| read(file)).collect::<Result<Vec<_>, _>>()?;
    Campaign::expand(specs).map_err(|failure| failure.to_string())
}

/// The numbers of the stages with these keys; `None` unless all are there.
fn numbers(campaign: &Campaign, keys: &[Key]) -> Option<Vec<usize>> {
    let graph = &campaign.graph;
    let by_key: HashMap<Key, usize> = (0..graph.len()).map(|number| (graph.describe(number).2, number)).collect();
    keys.iter().map(|key| by_key.get(key).copied()).collect()
}

fn tell_failures(folder: &Folder, campaign: &Campaign, outcomes: &Outcomes) -> Result<(), String> {
    for number in 0..campaign.graph.len() {
        if let Some(failure) = outcomes.failure(number) {
            folder.put_failure(&campaign.graph.describe(number).2, failure)?;
        }
    }
    Ok(())
}

fn missing(folder: &Folder, what: &str) -> String {
    format!("{}: found no such {what}, expected the folder of a campaign", folder.path().display())
}
