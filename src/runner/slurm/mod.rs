//! Campaigns on a Slurm cluster: an array of identical workers that fill a shared store. What is
//! done is what lies in the store; the queue only tells whether somebody is still at work.

mod campaign_folder;
mod monitor;
mod queue;
mod worker;

pub use campaign_folder::CampaignFolder;
pub use monitor::{CampaignEnd, CampaignMonitor};
pub use queue::{STAGES_LEFT_STATUS, workers_per_task};
pub use worker::{WorkerSummary, work};

use super::store::Store;

/// The state of a campaign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CampaignStatus {
    /// Its name.
    pub id: String,
    /// Its experiments.
    pub experiments: Vec<String>,
    /// Stages that were missing at its beginning.
    pub stages: usize,
    /// Those of them that are stored.
    pub done: usize,
    /// Stages that have failed.
    pub failed: usize,
    /// Whether it was cancelled.
    pub cancelled: bool,
    /// Its jobs by state, or the error of `squeue`.
    pub queue: String,
}

/// The campaigns of a store, by name.
pub fn campaigns(store: &Store) -> Vec<CampaignStatus> {
    CampaignFolder::ids(store).into_iter().filter_map(|id| status(store, id)).collect()
}

fn status(store: &Store, id: String) -> Option<CampaignStatus> {
    let folder = CampaignFolder::of(store, &id);
    let contents = folder.contents()?;
    Some(CampaignStatus {
        id,
        experiments: contents.experiments,
        stages: contents.stages.len(),
        done: contents.stages.iter().filter(|(kind, key)| store.contains(kind, key)).count(),
        failed: folder.failed().len(),
        cancelled: folder.marked(campaign_folder::CANCELLED).is_some(),
        queue: match queue::jobs(&folder.job_name()) {
            Ok(states) if states.is_empty() => "no jobs".to_owned(),
            Ok(states) => queue::describe(&states),
            Err(error) => error,
        },
    })
}

/// Cancels the jobs of a campaign and ends the process that waits for it; results stay in the
/// store.
///
/// # Errors
/// That there is no such campaign, or what the cluster says.
pub fn cancel(store: &Store, id: &str) -> Result<(), String> {
    let folder = CampaignFolder::of(store, id);
    if folder.contents().is_none() {
        let expected = CampaignFolder::ids(store).join(", ");
        let expected = if expected.is_empty() {
            "a campaign; this store has none".into()
        } else {
            format!("one of {expected}")
        };
        return Err(format!("found campaign `{id}`, expected {expected}"));
    }
    folder.mark(campaign_folder::CANCELLED, "")?;
    queue::cancel(&folder.job_name(), false)
}
