//! The content-addressed store: results of stages on disk, under their keys.
//!
//! An entry is written to a temporary file, flushed to the disk and renamed, so that it is either
//! whole or absent whenever the process dies. It carries the digest of its bytes and a seal over
//! key and digest, both checked on every read. Whoever computes an entry holds its lock, so that
//! processes that share a store share the work as well.

mod entry_lock;
mod gc;
mod place;

pub use entry_lock::EntryLock;
pub use gc::{EntryState, StoredEntry};
pub use place::store_folder;

use super::graph::digest::Digest;
use super::graph::key::Key;
use super::graph::timing::Timing;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

const MAGIC: &[u8; 16] = b"spinebench-rec-2";
/// Bytes before the payload: the magic, its digest and the seal.
const HEADER: usize = 16 + 32 + 32;

/// What the store has under a key.
#[derive(Debug, PartialEq)]
pub enum Lookup {
    /// The bytes, checked.
    Found(Vec<u8>),
    /// Nothing.
    Absent,
    /// Something that fails its check, and why.
    Damaged(String),
}

/// What is noted beside an entry: for manifests and for `cache`, never for results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Note {
    /// Which of its kind it is.
    pub label: String,
    /// Digest of the code that computed it.
    pub code: String,
    /// What it took.
    pub timing: Timing,
    /// What it was expected to cost, milliseconds; 0 in notes of earlier versions.
    #[serde(default)]
    pub cost_ms: u64,
}

/// What one process has asked of its store.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoreTraffic {
    /// Questions whether an entry is there.
    pub lookups: u64,
    /// Attempts to lock an entry.
    pub locks: u64,
    /// Entries read.
    pub reads: u64,
    /// Their size, bytes.
    pub read_bytes: u64,
    /// Entries written.
    pub writes: u64,
    /// Their size, bytes.
    pub written_bytes: u64,
}

/// A folder of entries.
#[derive(Debug)]
pub struct Store {
    root: PathBuf,
    next_temporary: AtomicU64,
    traffic: Mutex<StoreTraffic>,
    /// Lock files that other processes hold: when they were last touched, and when this process saw
    /// that.
    held_elsewhere: Mutex<HashMap<PathBuf, (SystemTime, Instant)>>,
    /// Age at which a lock that nobody touches is taken over.
    expiry: Duration,
}

/// Most entries of a kind whose times are read for an estimate.
const MAX_NOTES_READ: usize = 100;

impl Store {
    /// The store in the folder `root`, which is made when the first entry is written.
    pub fn at(root: impl Into<PathBuf>) -> Store {
        Store {
            root: root.into(),
            next_temporary: AtomicU64::new(0),
            traffic: Mutex::default(),
            held_elsewhere: Mutex::default(),
            expiry: entry_lock::EXPIRY,
        }
    }

    /// What this process has asked of the store so far.
    pub fn traffic(&self) -> StoreTraffic {
        *self.traffic.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn count(&self, add: impl FnOnce(&mut StoreTraffic)) {
        add(&mut self.traffic.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The file of an entry.
    pub fn path(&self, stage: &str, key: &Key) -> PathBuf {
        let name = key.to_string();
        self.root.join(stage).join(&name[..2]).join(name)
    }

    /// True when there is an entry; [`Store::read`] tells whether it is good.
    pub fn contains(&self, stage: &str, key: &Key) -> bool {
        self.count(|traffic| traffic.lookups += 1);
        self.path(stage, key).is_file()
    }

    /// The checked bytes of an entry.
    pub fn read(&self, stage: &str, key: &Key) -> Lookup {
        let mut bytes = match fs::read(self.path(stage, key)) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Lookup::Absent,
            Err(error) => return Lookup::Damaged(error.to_string()),
        };
        self.count(|traffic| {
            (traffic.reads, traffic.read_bytes) =
                (traffic.reads + 1, traffic.read_bytes + bytes.len() as u64)
        });
        let Some((header, payload)) = bytes.split_at_checked(HEADER) else {
            return Lookup::Damaged("it is truncated".into());
        };
        if &header[..16] != MAGIC {
            return Lookup::Damaged("it is of another format".into());
        }
        if header[16..48] != *Digest::of(payload).bytes()
            || header[48..] != seal(key, &header[16..48])
        {
            return Lookup::Damaged("its checksum does not match".into());
        }
        Lookup::Found(bytes.split_off(HEADER))
    }

    /// The digest of an entry's bytes as it says itself, if its seal holds; the bytes are not read.
    pub fn digest(&self, stage: &str, key: &Key) -> Option<Digest> {
        let mut header = [0; HEADER];
        File::open(self.path(stage, key)).ok()?.read_exact(&mut header).ok()?;
        let digest: [u8; 32] = header[16..48].try_into().ok()?;
        (header[..16] == *MAGIC && header[48..] == seal(key, &digest)).then(|| digest.into())
    }

    /// Files `payload` under a key, replacing what was there.
    ///
    /// # Errors
    /// What the file system says (no space, no permission); no half-written entry stays behind.
    pub fn write(&self, stage: &str, key: &Key, payload: &[u8]) -> io::Result<()> {
        let path = self.path(stage, key);
        let folder = path.parent().unwrap_or(&self.root);
        fs::create_dir_all(folder)?;
        let number = self.next_temporary.fetch_add(1, Ordering::Relaxed);
        let temporary = folder.join(format!(".{key}.{}.{number}.tmp", std::process::id()));
        let digest = Digest::of(payload);
        let written = (|| {
            let mut file = File::create(&temporary)?;
            file.write_all(MAGIC)?;
            file.write_all(digest.bytes())?;
            file.write_all(&seal(key, digest.bytes()))?;
            file.write_all(payload)?;
            file.sync_all()?;
            fs::rename(&temporary, &path)?;
            // The new name itself must survive a loss of power; systems that cannot flush a folder
            // do without.
            File::open(folder).and_then(|folder| folder.sync_all()).or(Ok(()))
        })();
        if written.is_err() {
            // Already failing: the first error is the one to report.
            let _ = fs::remove_file(&temporary);
        }
        let bytes = (HEADER + payload.len()) as u64;
        self.count(|traffic| {
            (traffic.writes, traffic.written_bytes) =
                (traffic.writes + 1, traffic.written_bytes + bytes)
        });
        written
    }

    /// Removes a damaged entry, so that nobody takes it for a stored one.
    pub fn discard(&self, stage: &str, key: &Key) {
        // What replaces it will report why this failed.
        let _ = fs::remove_file(self.path(stage, key));
    }

    /// Notes something beside an entry. A lost note costs a line of a manifest.
    pub fn note(&self, stage: &str, key: &Key, note: &Note) {
        if let Ok(text) = serde_json::to_vec(note) {
            let _ = fs::write(self.path(stage, key).with_extension("note"), text);
        }
    }

    /// What stages of this kind took when they were computed, over what they were expected to cost,
    /// of some of the entries.
    pub fn seconds_per_cost(&self, stage: &str) -> Option<f64> {
        let shelves = fs::read_dir(self.root.join(stage)).ok()?.flatten();
        let files =
            shelves.flat_map(|shelf| fs::read_dir(shelf.path()).into_iter().flatten().flatten());
        let notes = files
            .map(|file| file.path())
            .filter(|path| path.extension().is_some_and(|end| end == "note"));
        let read = |path: PathBuf| serde_json::from_slice::<Note>(&fs::read(path).ok()?).ok();
        let notes = notes.take(MAX_NOTES_READ).filter_map(read).filter(|note| note.cost_ms > 0);
        let (wall_s, cost_s) = notes.fold((0.0, 0.0), |(wall_s, cost_s), note| {
            (wall_s + note.timing.wall_s, cost_s + 1e-3 * note.cost_ms as f64)
        });
        (cost_s > 0.0).then(|| wall_s / cost_s)
    }

    /// What was noted beside an entry.
    pub fn noted(&self, stage: &str, key: &Key) -> Option<Note> {
        serde_json::from_slice(&fs::read(self.path(stage, key).with_extension("note")).ok()?).ok()
    }
}

/// The seal covers the key, so that an entry under another's name is found out.
fn seal(key: &Key, digest: &[u8]) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(key.bytes());
    hasher.update(digest);
    *hasher.finalize().as_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_back_and_every_flipped_byte_or_lost_end_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path().join("cache"));
        let key = Digest::of(b"key");
        assert_eq!(store.read("stage", &key), Lookup::Absent);
        store.write("stage", &key, b"payload").unwrap();
        assert_eq!(store.read("stage", &key), Lookup::Found(b"payload".to_vec()));
        assert_eq!(store.digest("stage", &key), Some(Digest::of(b"payload")));

        let path = store.path("stage", &key);
        let good = fs::read(&path).unwrap();
        for index in 0..good.len() {
            let mut bad = good.clone();
            bad[index] ^= 0x10;
            fs::write(&path, &bad).unwrap();
            assert!(matches!(store.read("stage", &key), Lookup::Damaged(_)), "byte {index}");
            fs::write(&path, &good[..index]).unwrap();
            assert!(matches!(store.read("stage", &key), Lookup::Damaged(_)), "length {index}");
        }
        // A good entry under another's name.
        let other = Digest::of(b"other");
        fs::create_dir_all(store.path("stage", &other).parent().unwrap()).unwrap();
        fs::write(store.path("stage", &other), &good).unwrap();
        assert!(matches!(store.read("stage", &other), Lookup::Damaged(_)));
        assert_eq!(store.digest("stage", &other), None);

        store.write("stage", &key, b"payload").unwrap();
        assert_eq!(store.read("stage", &key), Lookup::Found(b"payload".to_vec()));
        let left = fs::read_dir(path.parent().unwrap()).unwrap().count();
        assert_eq!(left, 1, "no temporary file stays behind");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("cache"), "a file").unwrap();
        let store = Store::at(folder.path().join("cache"));
        assert!(store.write("stage", &Digest::of(b"key"), b"x").is_err());
    }
}
