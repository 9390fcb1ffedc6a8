//! Keeping the store: what lies in it, whether it is good, and taking out what is of no use.

use super::{Lookup, Note, Store};
use crate::runner::graph::digest::Digest;
use crate::runner::graph::key::Key;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// One entry, as it lies there.
#[derive(Clone, Debug)]
pub struct StoredEntry {
    /// Kind of stage.
    pub stage: String,
    /// Its key.
    pub key: Key,
    /// Bytes on disk, its note left out.
    pub bytes: u64,
    /// Time since it was written.
    pub age: Duration,
    /// What was noted beside it.
    pub note: Option<Note>,
}

/// What an entry is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EntryState {
    /// The present code may read it.
    Current,
    /// Other code computed it; the present code computes its own.
    Stale,
}

impl StoredEntry {
    /// Whether the present code may read it, by the digests of the code of each kind of stage.
    pub fn state(&self, codes: &BTreeMap<&str, Digest>) -> EntryState {
        let current = codes.get(self.stage.as_str()).map(Digest::to_string);
        let noted = self.note.as_ref().map(|note| &note.code);
        // An entry whose note was lost may be anybody's: it is kept.
        if current.is_some() && (noted.is_none() || noted == current.as_ref()) {
            EntryState::Current
        } else {
            EntryState::Stale
        }
    }
}

impl Store {
    /// All entries, by kind and key.
    ///
    /// # Errors
    /// What the file system says of a folder; a store that does not exist is empty.
    pub fn entries(&self) -> io::Result<Vec<StoredEntry>> {
        let mut entries = Vec::new();
        self.visit(|stage, path, name| {
            if let Some(key) = Digest::parse(name) {
                let metadata = fs::metadata(path)?;
                let age = metadata
                    .modified()
                    .ok()
                    .and_then(|at| SystemTime::now().duration_since(at).ok());
                let (stage, note) = (stage.to_owned(), self.noted(stage, &key));
                entries.push(StoredEntry {
                    stage,
                    key,
                    bytes: metadata.len(),
                    age: age.unwrap_or_default(),
                    note,
                });
            }
            Ok(())
        })?;
        entries.sort_by(|one, other| (&one.stage, one.key).cmp(&(&other.stage, other.key)));
        Ok(entries)
    }

    /// Why an entry cannot be believed; `None` for a good one.
    pub fn damage(&self, entry: &StoredEntry) -> Option<String> {
        match self.read(&entry.stage, &entry.key) {
            Lookup::Found(_) => None,
            Lookup::Absent => Some("it no longer exists".to_owned()),
            Lookup::Damaged(reason) => Some(reason),
        }
    }

    /// Takes out an entry and its note.
    ///
    /// # Errors
    /// What the file system says.
    pub fn remove(&self, entry: &StoredEntry) -> io::Result<()> {
        let path = self.path(&entry.stage, &entry.key);
        let _ = fs::remove_file(path.with_extension("note")); // there may be none
        fs::remove_file(path)
    }

    /// Temporary files of writers that died, with their sizes: those of whose entry nobody holds
    /// the lock.
    ///
    /// # Errors
    /// What the file system says of a folder.
    pub fn leftovers(&self) -> io::Result<Vec<(PathBuf, u64)>> {
        let mut leftovers = Vec::new();
        self.visit(|stage, path, name| {
            let key =
                name.strip_prefix('.').and_then(|name| Digest::parse(name.split('.').next()?));
            if let Some(key) = key.filter(|_| name.ends_with(".tmp"))
                && self.lock(stage, &key).is_some()
            {
                leftovers.push((
                    path.to_owned(),
                    fs::metadata(path).map_or(0, |metadata| metadata.len()),
                ));
            }
            Ok(())
        })?;
        leftovers.sort();
        Ok(leftovers)
    }

    /// Shows every file of the folders of entries: kind of stage, path and name.
    fn visit(&self, mut show: impl FnMut(&str, &Path, &str) -> io::Result<()>) -> io::Result<()> {
        for kind in folders(&self.root)? {
            let stage = kind.file_name().unwrap_or_default().to_string_lossy().into_owned();
            // Entries lie in folders named by the first two digits of their keys.
            let shelves = folders(&kind)?;
            for shelf in
                shelves.iter().filter(|shelf| shelf.file_name().is_some_and(|name| name.len() == 2))
            {
                for file in fs::read_dir(shelf)? {
                    let path = file?.path();
                    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    show(&stage, &path, &name)?;
                }
            }
        }
        Ok(())
    }
}

/// The folders in a folder; none where there is no such folder.
fn folders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other?,
    };
    let paths = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<io::Result<Vec<PathBuf>>>()?;
    Ok(paths.into_iter().filter(|path| path.is_dir()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runner::graph::timing::Timing;

    #[test]
    fn entries_are_listed_with_their_state_and_leftovers_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path());
        assert!(store.entries().unwrap().is_empty());
        let (old, new) = (Digest::of(b"old"), Digest::of(b"new"));
        for (key, code) in [(&old, "1"), (&new, "2")] {
            store.write("stage", key, b"payload").unwrap();
            let code = Digest::of(code.as_bytes()).to_string();
            store.note(
                "stage",
                key,
                &Note { label: "one".into(), code, timing: Timing::default(), cost_ms: 1 },
            );
        }
        let codes = BTreeMap::from([("stage", Digest::of(b"2"))]);
        let entries = store.entries().unwrap();
        let states: BTreeMap<Key, EntryState> =
            entries.iter().map(|entry| (entry.key, entry.state(&codes))).collect();
        assert_eq!(states, BTreeMap::from([(old, EntryState::Stale), (new, EntryState::Current)]));

        let left = store.path("stage", &old).with_file_name(format!(".{old}.77.0.tmp"));
        fs::write(&left, "half").unwrap();
        let held = store.lock("stage", &old);
        assert!(store.leftovers().unwrap().is_empty(), "somebody is writing it");
        drop(held);
        assert_eq!(store.leftovers().unwrap(), [(left, 4)]);

        fs::write(store.path("stage", &new), "rubbish").unwrap();
        let damaged: Vec<bool> =
            entries.iter().map(|entry| store.damage(entry).is_some()).collect();
        assert_eq!(damaged.iter().filter(|damaged| **damaged).count(), 1);
        entries.iter().for_each(|entry| store.remove(entry).unwrap());
        assert!(store.entries().unwrap().is_empty());
    }
}
