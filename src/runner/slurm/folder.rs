//! What the processes of one campaign on a cluster tell each other, as files beside the store's entries.

use super::plan::Task;
use crate::data::write_atomic;
use crate::runner::digest::Digest;
use crate::runner::graph::{Failure, Graph};
use crate::runner::key::Key;
use crate::runner::store::Store;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of a campaign.
#[derive(Clone, Debug)]
pub struct Folder {
    root: PathBuf,
}

/// What a campaign is about.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Names of its experiments.
    pub experiments: Vec<String>,
    /// Keys of the stages that are waited for.
    pub waited_for: Vec<Key>,
    /// Their kinds.
    pub kinds: Vec<String>,
}

/// What was submitted at once: waves of tasks, each task the keys of the stages that it has to see done.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Attempt {
    /// Waves of tasks.
    pub waves: Vec<Vec<Vec<Key>>>,
}

impl Folder {
    /// The folder of the campaign `id` in a store.
    pub fn of(store: &Store, id: &str) -> Folder {
        Folder { root: store.root().join("slurm").join(id) }
    }

    /// An existing folder.
    pub fn at(root: &Path) -> Folder {
        Folder { root: root.to_owned() }
    }

    /// Names of all campaigns of a store.
    pub fn ids(store: &Store) -> Vec<String> {
        let found = fs::read_dir(store.root().join("slurm")).into_iter().flatten().flatten();
        let mut ids: Vec<String> = found.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        ids.sort();
        ids
    }

    /// The name of the campaign for these keys.
    pub fn id(keys: impl Iterator<Item = Key>) -> String {
        let bytes: Vec<u8> = keys.flat_map(|key| *key.bytes()).collect();
        Digest::of(&bytes).short()
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.root
    }

    /// The store that it lies in.
    pub fn store(&self) -> Store {
        Store::at(self.root.parent().and_then(Path::parent).unwrap_or(&self.root))
    }

    /// The folder of the tasks' output.
    pub fn logs(&self) -> PathBuf {
        self.root.join("log")
    }

    /// Writes down what the campaign is about, unless it was begun before.
    ///
    /// # Errors
    /// What the file system says.
    pub fn begin(&self, specs: &[Vec<u8>], about: &About) -> Result<(), String> {
        if self.about().is_some() {
            return Ok(());
        }
        fs::create_dir_all(self.logs()).map_err(|error| format!("{}: {error}", self.logs().display()))?;
        for (number, spec) in specs.iter().enumerate() {
            put(&self.root.join("specs").join(format!("{number}.yaml")), spec)?;
        }
        put_json(&self.root.join("about.json"), about)
    }

    /// What it is about; `None` where nothing was begun.
    pub fn about(&self) -> Option<About> {
        get_json(&self.root.join("about.json"))
    }

    /// Files of its specs, in their order.
    pub fn specs(&self) -> Vec<PathBuf> {
        (0..)
            .map(|number| self.root.join("specs").join(format!("{number}.yaml")))
            .take_while(|file| file.is_file())
            .collect()
    }

    /// Number of the last attempt; 0 where nothing was submitted.
    pub fn last_attempt(&self) -> usize {
        (1..).take_while(|&number| self.attempt_file(number).is_file()).last().unwrap_or(0)
    }

    fn attempt_file(&self, number: usize) -> PathBuf {
        self.root.join(format!("attempt-{number}.json"))
    }

    /// Writes down the tasks of an attempt.
    ///
    /// # Errors
    /// What the file system says.
    pub fn put_attempt(&self, number: usize, graph: &Graph, waves: &[Vec<Task>]) -> Result<(), String> {
        let keys = |task: &Task| task.iter().map(|&stage| graph.describe(stage).2).collect();
        let waves = waves.iter().map(|tasks| tasks.iter().map(keys).collect()).collect();
        put_json(&self.attempt_file(number), &Attempt { waves })
    }

    /// The tasks of an attempt.
    pub fn attempt(&self, number: usize) -> Option<Attempt> {
        get_json(&self.attempt_file(number))
    }

    /// Writes down that a stage has failed, so that nobody tries it again.
    ///
    /// # Errors
    /// What the file system says.
    pub fn put_failure(&self, key: &Key, failure: &Failure) -> Result<(), String> {
        put_json(&self.root.join("failed").join(key.to_string()), failure)
    }

    /// The stages that have failed.
    pub fn failures(&self) -> HashMap<Key, Failure> {
        let found = fs::read_dir(self.root.join("failed")).into_iter().flatten().flatten();
        let failure = |entry: fs::DirEntry| {
            Some((Digest::parse(&entry.file_name().to_string_lossy())?, get_json(&entry.path())?))
        };
        found.filter_map(failure).collect()
    }

    /// Forgets failures: a new run tries again.
    pub fn forget_failures(&self) {
        let _ = fs::remove_dir_all(self.root.join("failed")); // there may be none
    }

    /// Marks the campaign as called off, or takes the mark away.
    ///
    /// # Errors
    /// What the file system says.
    pub fn call_off(&self, off: bool) -> Result<(), String> {
        let mark = self.root.join("cancelled");
        if off {
            return put(&mark, b"");
        }
        let _ = fs::remove_file(mark); // there may be none
        Ok(())
    }

    /// Whether it was called off.
    pub fn called_off(&self) -> bool {
        self.root.join("cancelled").is_file()
    }

    /// The right to submit and watch, until it is dropped; `None` while another process has it.
    pub fn watch(&self) -> Option<fs::File> {
        let file = fs::File::options().append(true).create(true).open(self.root.join("watched")).ok()?;
        match file.try_lock() {
            Err(fs::TryLockError::WouldBlock) => None,
            // A file system without locks: nobody else is assumed.
            Ok(()) | Err(fs::TryLockError::Error(_)) => Some(file),
        }
    }
}

fn put(path: &Path, bytes: &[u8]) -> Result<(), String> {
    write_atomic(path, bytes).map_err(|error| error.to_string())
}

fn put_json(path: &Path, value: &impl Serialize) -> Result<(), String> {
    put(path, &serde_json::to_vec(value).map_err(|error| error.to_string())?)
}

fn get_json<T: DeserializeOwned>(path: &Path) -> Option<T> {
    serde_json::from_slice(&fs::read(path).ok()?).ok()
}
