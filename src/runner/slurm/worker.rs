//! One worker of a campaign: takes what is left until nothing is, or until its time is nearly over.

use super::campaign_folder::{CampaignFolder, FINISHED, REFUSED};
use crate::hardware::interrupt::Interrupt;
use crate::runner::execute::executor::{RunOptions, WorkerShare, execute_share};
use crate::runner::execute::outcomes::SharingCost;
use crate::runner::execute::progress::Progress;
use crate::runner::store::StoreTraffic;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// What one worker did, and what it cost that others worked beside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorkerSummary {
    /// Stages that it computed.
    pub computed: usize,
    /// Time that its threads spent on them, seconds.
    pub computing_s: f64,
    /// Time from its start to its end, seconds.
    pub wall_s: f64,
    /// Whether it was told to end while stages were left.
    pub stopped: bool,
    /// Cost of sharing.
    pub sharing: SharingCost,
    /// What it asked of the store.
    pub traffic: StoreTraffic,
}

/// Works as number `worker` of `workers` (from 0). SIGUSR2 tells it to complete what it has begun
/// and to end.
///
/// # Errors
/// What the campaign's folder lacks; that this is another build than the one that submitted it.
pub fn work(
    folder: &CampaignFolder,
    worker: usize,
    workers: usize,
    threads: usize,
    progress: &Progress,
) -> Result<WorkerSummary, String> {
    let started = Instant::now();
    let notice = Interrupt::of_batch().map_err(|error| error.to_string())?;
    if folder.marked(FINISHED).is_some() {
        return Ok(WorkerSummary::default());
    }
    let root = folder.path().display();
    let missing = folder
        .missing()
        .ok_or_else(|| format!("{root}: found no missing.json, expected a campaign"))?;
    let campaign = folder.campaign()?;
    if !folder.path().ends_with(CampaignFolder::id_of(&campaign)) {
        let text = "the workers found another build of the program, or another recording to \
                    replay, than those submitted";
        folder.mark(REFUSED, text)?;
        return Err(text.to_owned());
    }
    let options = RunOptions { threads, progress, stop: notice.flag(), record: folder };
    let share = WorkerShare { worker, workers, missing: &missing };
    let store = folder.store();
    let outcomes = execute_share(&campaign.graph, &store, share, &options)
        .map_err(|failure| failure.to_string())?;
    if outcomes.sharing.left == 0 {
        folder.mark(FINISHED, "")?;
    }
    let summary = WorkerSummary {
        computed: outcomes.computed,
        computing_s: outcomes.timings.iter().flatten().map(|timing| timing.wall_s).sum(),
        wall_s: started.elapsed().as_secs_f64(),
        stopped: outcomes.stopped,
        sharing: outcomes.sharing,
        traffic: store.traffic(),
    };
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let run = format!("{}-{worker}-{}", variable("SLURM_JOB_ID"), variable("SLURM_RESTART_COUNT"));
    folder.put_summary(&run, &summary)?;
    progress.say(&serde_json::to_string(&summary).map_err(|error| error.to_string())?);
    Ok(summary)
}

impl WorkerSummary {
    /// Several workers together, in words.
    pub(super) fn describe(all: &[WorkerSummary]) -> String {
        let count = |number: fn(&WorkerSummary) -> u64| all.iter().map(number).sum::<u64>();
        let time = |number: fn(&WorkerSummary) -> f64| all.iter().map(number).sum::<f64>();
        format!(
            "{} worker runs of {:.1} s: {} stages computed in {:.1} s; {} locks lost, {} stages \
             computed twice ({:.1} s), {} polls, {:.1} s without work; {} results read ({:.1} MB), \
             {} written ({:.1} MB), {} lookups, {} locks",
            all.len(),
            time(|summary| summary.wall_s),
            count(|summary| summary.computed as u64),
            time(|summary| summary.computing_s),
            count(|summary| summary.sharing.locks_lost as u64),
            count(|summary| summary.sharing.duplicates as u64),
            time(|summary| summary.sharing.duplicate_s),
            count(|summary| summary.sharing.polls as u64),
            time(|summary| summary.sharing.idle_s),
            count(|summary| summary.traffic.reads),
            time(|summary| summary.traffic.read_bytes as f64 / 1e6),
            count(|summary| summary.traffic.writes),
            time(|summary| summary.traffic.written_bytes as f64 / 1e6),
            count(|summary| summary.traffic.lookups),
            count(|summary| summary.traffic.locks),
        )
    }
}
