//! The folder of a campaign in the store: what its submitter and its workers tell each other.

use super::worker::WorkerSummary;
use crate::data::write_atomic;
use crate::runner::campaign::Campaign;
use crate::runner::execute::executor::RunRecord;
use crate::runner::graph::Failure;
use crate::runner::graph::digest::Digest;
use crate::runner::graph::key::Key;
use crate::runner::store::Store;
use crate::specs::ExperimentSet;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::collections::HashSet;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Marks: all is done; cancelled; the workers cannot compute it, with the reason.
pub(super) const FINISHED: &str = "finished";
pub(super) const CANCELLED: &str = "cancelled";
pub(super) const REFUSED: &str = "refused";
/// How long a worker believes its list of failures: a stage may fail twice within that time.
const MAX_FAILURES_AGE: Duration = Duration::from_secs(5);

/// The folder of a campaign.
#[derive(Debug)]
pub struct CampaignFolder {
    root: PathBuf,
    /// Stages that have failed, and when they were listed.
    listed_failures: Mutex<Option<(Instant, HashSet<Key>)>>,
}

/// What a campaign computes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct CampaignContents {
    /// Names of its experiments.
    pub(super) experiments: Vec<String>,
    /// Kinds and keys of the stages that were missing at its beginning.
    pub(super) stages: Vec<(String, Key)>,
}

impl CampaignFolder {
    /// An existing folder.
    pub fn at(root: &Path) -> CampaignFolder {
        CampaignFolder { root: root.to_owned(), listed_failures: Mutex::default() }
    }

    /// The folder of the campaign `id` in a store.
    pub(super) fn of(store: &Store, id: &str) -> CampaignFolder {
        CampaignFolder::at(&store.root().join("slurm").join(id))
    }

    /// Names of all campaigns of a store.
    pub(super) fn ids(store: &Store) -> Vec<String> {
        names(&store.root().join("slurm"))
    }

    /// The name of a campaign: what asks for the same results of the same code has the same name.
    pub(super) fn id_of(campaign: &Campaign) -> String {
        let keys = campaign.wanted().into_iter().map(|stage| campaign.graph.describe(stage).2);
        Digest::of(&keys.flat_map(|key| *key.bytes()).collect::<Vec<u8>>()).short()
    }

    pub(super) fn path(&self) -> &Path {
        &self.root
    }

    pub(super) fn logs(&self) -> PathBuf {
        self.root.join("log")
    }

    /// The store that it lies in.
    pub(super) fn store(&self) -> Store {
        Store::at(self.root.parent().and_then(Path::parent).unwrap_or(&self.root))
    }

    /// Name of all its jobs: the campaign for the same results in another store has another.
    pub(super) fn job_name(&self) -> String {
        let root = fs::canonicalize(&self.root).unwrap_or_else(|_| self.root.clone());
        format!("spinebench-{}", Digest::of(root.as_os_str().as_encoded_bytes()).short())
    }

    /// Writes what the campaign computes, unless that is there.
    pub(super) fn create(
        &self,
        specs: &[Vec<u8>],
        contents: &CampaignContents,
    ) -> Result<(), String> {
        if self.contents().is_some() {
            return Ok(());
        }
        fs::create_dir_all(self.logs())
            .map_err(|error| format!("{}: {error}", self.logs().display()))?;
        for (number, spec) in specs.iter().enumerate() {
            self.write(&format!("specs/{number}.yaml"), spec)?;
        }
        self.write_json("contents.json", contents)
    }

    pub(super) fn contents(&self) -> Option<CampaignContents> {
        self.read_json("contents.json")
    }

    /// The campaign, expanded from its specs.
    pub(super) fn campaign(&self) -> Result<Campaign, String> {
        let file = |number: usize| self.root.join("specs").join(format!("{number}.yaml"));
        let files = (0..).map(file).take_while(|file| file.is_file());
        let read =
            |file: PathBuf| ExperimentSet::read(&file, &[], &[]).map_err(|error| error.to_string());
        Campaign::expand(files.map(read).collect::<Result<Vec<_>, _>>()?)
            .map_err(|failure| failure.to_string())
    }

    /// Numbers of the stages that were missing when the workers were submitted.
    pub(super) fn missing(&self) -> Option<Vec<usize>> {
        self.read_json("missing.json")
    }

    pub(super) fn put_missing(&self, stages: &[usize]) -> Result<(), String> {
        self.write_json("missing.json", &stages)
    }

    pub(super) fn mark(&self, mark: &str, text: &str) -> Result<(), String> {
        self.write(mark, text.as_bytes())
    }

    pub(super) fn marked(&self, mark: &str) -> Option<String> {
        fs::read_to_string(self.root.join(mark)).ok()
    }

    /// Removes marks, or folders of failures and summaries; there may be none.
    pub(super) fn forget(&self, names: &[&str]) {
        for path in names.iter().map(|name| self.root.join(name)) {
            let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        }
    }

    /// Keys of the stages that have failed.
    pub(super) fn failed(&self) -> HashSet<Key> {
        let names = names(&self.root.join("failed"));
        let failed: HashSet<Key> = names.iter().filter_map(|name| Digest::parse(name)).collect();
        *self.listed_failures.lock().unwrap_or_else(PoisonError::into_inner) =
            Some((Instant::now(), failed.clone()));
        failed
    }

    pub(super) fn put_summary(&self, name: &str, summary: &WorkerSummary) -> Result<(), String> {
        self.write_json(&format!("workers/{name}.json"), summary)
    }

    /// What its workers did that have ended, in words.
    pub fn describe_workers(&self) -> String {
        let names = names(&self.root.join("workers"));
        let summaries = names.iter().filter_map(|name| self.read_json(&format!("workers/{name}")));
        WorkerSummary::describe(&summaries.collect::<Vec<_>>())
    }

    /// The right to submit and to wait, until it is dropped; `None` while another process has it.
    pub(super) fn lock(&self) -> Option<File> {
        let file =
            File::options().append(true).create(true).open(self.root.join("watched")).ok()?;
        // On a file system without locks nobody else is assumed.
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) { None } else { Some(file) }
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), String> {
        write_atomic(&self.root.join(name), bytes).map_err(|error| error.to_string())
    }

    fn write_json(&self, name: &str, value: &impl Serialize) -> Result<(), String> {
        self.write(name, &serde_json::to_vec(value).map_err(|error| error.to_string())?)
    }

    fn read_json<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        serde_json::from_slice(&fs::read(self.root.join(name)).ok()?).ok()
    }
}

impl RunRecord for CampaignFolder {
    fn find_failure(&self, key: &Key) -> Option<Failure> {
        let listed_failures =
            self.listed_failures.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let fresh = listed_failures
            .filter(|(at, _)| at.elapsed() < MAX_FAILURES_AGE)
            .map(|(_, failed)| failed);
        let failed = fresh.unwrap_or_else(|| self.failed());
        if failed.contains(key) { self.read_json(&format!("failed/{key}")) } else { None }
    }

    fn record_failure(&self, key: &Key, failure: &Failure) {
        // At worst another worker tries the stage again.
        let _ = self.write_json(&format!("failed/{key}"), failure);
        self.failed();
    }

    fn finished_shares(&self) -> Vec<usize> {
        names(&self.root.join("shares")).iter().filter_map(|name| name.parse().ok()).collect()
    }

    fn record_share(&self, share: usize) {
        let _ = self.write(&format!("shares/{share}"), b""); // at worst others look for its stages
    }
}

/// Names of what lies in a folder, sorted; none where there is no folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
