//! Claims: who computes an entry. A claim is a lock that the system takes away when its process dies, however it dies.
//!
//! On a shared folder the locks of Linux reach across machines (NFS since kernel 2.6.12, Lustre mounted with `flock`).
//! Where a folder has none, two processes may compute the same entry: twice the work, the same bytes.

use super::Store;
use crate::runner::key::Key;
use std::fs::{self, File, TryLockError};
use std::path::PathBuf;

/// The right to compute an entry, given back when dropped.
#[derive(Debug)]
pub struct EntryLock {
    file: Option<File>,
    path: PathBuf,
}

/// What came of asking for a claim.
#[derive(Debug)]
pub enum LockAttempt {
    /// It is ours.
    Acquired(EntryLock),
    /// Another process computes this entry now.
    HeldElsewhere,
}

impl Store {
    /// Claims an entry. Who gets it looks into the store once more: another may have finished meanwhile.
    pub fn try_lock(&self, stage: &str, key: &Key) -> LockAttempt {
        let folder = self.root.join("claims");
        let path = folder.join(format!("{stage}-{}", key.short()));
        let file = fs::create_dir_all(&folder).and_then(|()| File::options().append(true).create(true).open(&path));
        // Without a file there is no lock: the store takes nothing, which its writes will tell.
        let Ok(file) = file else { return LockAttempt::Acquired(EntryLock { file: None, path }) };
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => LockAttempt::HeldElsewhere,
            Ok(()) | Err(TryLockError::Error(_)) => LockAttempt::Acquired(EntryLock { file: Some(file), path }),
        }
    }
}

impl Drop for EntryLock {
    fn drop(&mut self) {
        // Removed while it is held. One who has it open meanwhile gets a lock on nothing and finds the entry there.
        if self.file.is_some() {
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runner::digest::Digest;

    #[test]
    fn an_entry_is_claimed_once_until_it_is_given_back() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (Store::at(folder.path()), Store::at(folder.path()));
        let key = Digest::of(b"key");
        let held = one.try_lock("stage", &key);
        assert!(matches!(held, LockAttempt::Acquired(_)));
        assert!(matches!(other.try_lock("stage", &key), LockAttempt::HeldElsewhere));
        assert!(matches!(other.try_lock("stage", &Digest::of(b"another")), LockAttempt::Acquired(_)));
        drop(held);
        assert!(matches!(other.try_lock("stage", &key), LockAttempt::Acquired(_)));
        assert_eq!(fs::read_dir(folder.path().join("claims")).unwrap().count(), 0, "claims leave nothing behind");
    }

    #[test]
    fn a_store_that_takes_nothing_claims_everything() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "").unwrap();
        assert!(matches!(
            Store::at(folder.path().join("file")).try_lock("stage", &Digest::of(b"k")),
            LockAttempt::Acquired(_)
        ));
    }
}
