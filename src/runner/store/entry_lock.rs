//! Locks of entries: who computes a result. The system releases a lock when its process dies,
//! however it dies.
//!
//! On a shared folder the locks of Linux (`flock`) reach across machines: NFS since kernel 2.6.12,
//! Lustre mounted with `flock`, GPFS. Such a server may keep the lock of a machine that lost power:
//! NFS 4 for its lease of 90 s, NFS 3 until the machine is back. So the holder touches its lock
//! file every 30 s, and a lock whose file has not changed for 180 s is taken over. The waiting
//! process measures that time on its own clock: clocks need not agree. Where a folder has no locks,
//! or a holder was only suspended, two processes may compute the same entry: twice the work, the
//! same bytes.

use super::Store;
use crate::runner::graph::key::Key;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::PoisonError;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant, SystemTime};

/// How often a holder touches its lock file.
const TOUCH_INTERVAL: Duration = Duration::from_secs(30);
/// Age of a lock that nobody touches at which it is taken over: longer than a network file system
/// caches a file's time.
pub(super) const EXPIRY: Duration = Duration::from_secs(180);

/// The right to compute an entry, given back when dropped.
#[derive(Debug)]
pub struct EntryLock {
    path: PathBuf,
    /// Ends the thread that touches the file when it is dropped. `None` where the store takes no
    /// files.
    alive: Option<Sender<()>>,
}

impl Store {
    /// Locks an entry; `None` while another process holds its lock. Who gets the lock looks into
    /// the store once more: another process may have finished meanwhile.
    pub fn lock(&self, stage: &str, key: &Key) -> Option<EntryLock> {
        let folder = self.root.join("locks");
        let path = folder.join(format!("{stage}-{}", key.short()));
        self.count(|traffic| traffic.locks += 1);
        let open = || File::options().append(true).create(true).open(&path);
        // Without a file there is no lock: the store takes nothing, as its writes will report.
        let Ok(mut file) = open().or_else(|_| fs::create_dir_all(&folder).and_then(|()| open()))
        else {
            return Some(EntryLock { path, alive: None });
        };
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            if !self.has_expired(&path, &file) {
                return None;
            }
            let _ = fs::remove_file(&path); // another process may have been quicker
            file = open().ok()?;
            if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
                return None;
            }
        }
        let (alive, dropped) = channel();
        let touch = move || {
            while dropped.recv_timeout(TOUCH_INTERVAL) == Err(RecvTimeoutError::Timeout) {
                let _ = file.set_modified(SystemTime::now()); // at worst another process takes over
            }
        };
        // At worst the same.
        let _ = std::thread::Builder::new().name("lock".to_owned()).spawn(touch);
        Some(EntryLock { path, alive: Some(alive) })
    }

    /// Whether a held lock's file has not changed for long enough, as this process has seen it.
    fn has_expired(&self, path: &Path, file: &File) -> bool {
        let Ok(touched) = file.metadata().and_then(|file| file.modified()) else { return false };
        let mut held = self.held_elsewhere.lock().unwrap_or_else(PoisonError::into_inner);
        let last_change = held.entry(path.to_owned()).or_insert((touched, Instant::now()));
        if last_change.0 != touched {
            *last_change = (touched, Instant::now());
        }
        let expired = last_change.1.elapsed() >= self.expiry;
        if expired {
            held.remove(path);
        }
        expired
    }
}

impl Drop for EntryLock {
    fn drop(&mut self) {
        // Removed while it is locked. A process that has it open locks a file without a name and
        // finds the entry stored.
        if self.alive.is_some() {
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runner::graph::digest::Digest;

    #[test]
    fn an_entry_is_locked_once_until_the_lock_is_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (Store::at(folder.path()), Store::at(folder.path()));
        let key = Digest::of(b"key");
        let held = one.lock("stage", &key);
        assert!(held.is_some());
        assert!(other.lock("stage", &key).is_none());
        assert!(other.lock("stage", &Digest::of(b"another")).is_some());
        drop(held);
        assert!(other.lock("stage", &key).is_some());
        assert_eq!(
            fs::read_dir(folder.path().join("locks")).unwrap().count(),
            0,
            "locks leave nothing behind"
        );
    }

    #[test]
    fn a_store_that_takes_nothing_locks_everything() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "").unwrap();
        assert!(Store::at(folder.path().join("file")).lock("stage", &Digest::of(b"k")).is_some());
    }

    /// The lock of a machine without power, which the file server still keeps: nobody touches its
    /// file.
    #[test]
    fn a_lock_that_nobody_touches_is_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let (mut store, key) = (Store::at(folder.path()), Digest::of(b"key"));
        store.expiry = Duration::from_millis(300);
        drop(store.lock("stage", &key));
        let path = folder.path().join("locks").join(format!("stage-{}", key.short()));
        let dead = File::create(&path).unwrap();
        dead.lock().unwrap();
        assert!(store.lock("stage", &key).is_none(), "first seen now");
        std::thread::sleep(Duration::from_millis(200));
        dead.set_modified(SystemTime::now()).unwrap();
        std::thread::sleep(Duration::from_millis(200));
        assert!(store.lock("stage", &key).is_none(), "touched since");
        std::thread::sleep(Duration::from_millis(400));
        let taken = store.lock("stage", &key);
        assert!(taken.is_some(), "not touched for longer than the expiry");
        assert!(store.lock("stage", &key).is_none(), "the new holder has it");
    }
}
