//! How campaigns stand, for people who have detached from them.

use super::folder::Folder;
use super::{job_name, queue};
use crate::runner::store::Store;

/// How a campaign stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Standing {
    /// Its name.
    pub id: String,
    /// Its experiments.
    pub experiments: Vec<String>,
    /// Stages that are waited for.
    pub stages: usize,
    /// Those of them that are in the store.
    pub done: usize,
    /// Stages that have failed.
    pub failed: usize,
    /// Whether it was called off.
    pub cancelled: bool,
    /// Its tasks in the queue by state, in words; or what the cluster said instead.
    pub queue: String,
}

/// How the campaigns of a store stand, by name.
pub fn standing(store: &Store) -> Vec<Standing> {
    Folder::ids(store).into_iter().filter_map(|id| one(store, id)).collect()
}

fn one(store: &Store, id: String) -> Option<Standing> {
    let folder = Folder::of(store, &id);
    let about = folder.about()?;
    let done = about.waited_for.iter().zip(&about.kinds).filter(|(key, kind)| store.contains(kind, key)).count();
    Some(Standing {
        experiments: about.experiments,
        stages: about.waited_for.len(),
        done,
        failed: folder.failures().len(),
        cancelled: folder.called_off(),
        queue: match queue::queued(&job_name(&folder)) {
            Ok(states) if states.is_empty() => "no jobs".to_owned(),
            Ok(states) => queue::words(&states),
            Err(words) => words,
        },
        id,
    })
}

/// Calls a campaign off: its jobs are cancelled, and whoever watches it ends.
///
/// # Errors
/// That there is no such campaign, or what the cluster says.
pub fn cancel(store: &Store, id: &str) -> Result<(), String> {
    let folder = Folder::of(store, id);
    if folder.about().is_none() {
        let known = Folder::ids(store).join(", ");
        let known =
            if known.is_empty() { "a campaign; this store has none".to_owned() } else { format!("one of {known}") };
        return Err(format!("found campaign `{id}`, expected {known}"));
    }
    folder.call_off(true)?;
    queue::cancel(&job_name(&folder))
}
