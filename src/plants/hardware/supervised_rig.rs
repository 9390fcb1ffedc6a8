//! The rig of one robot with the thread that watches it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use crate::hardware::clock::Clock;
use crate::hardware::realtime::{Priority, RealTime};
use crate::hardware::rig::Rig;

/// How often the rig is looked at, s.
const WATCH_S: f64 = 0.005;
/// Longest that a robot is waited for at the end until it stands and what is queued is forgotten, s: a controller that
/// answers late must still be heard.
const LEAVE_S: f64 = 5.0;

/// A rig that is watched whatever its user does.
pub(crate) struct SupervisedRig {
    rig: Arc<Mutex<Rig>>,
    pub(crate) clock: Arc<dyn Clock>,
    over: Arc<AtomicBool>,
    watch: Option<JoinHandle<()>>,
}

impl SupervisedRig {
    /// Watches `rig` from now on. The calling thread has joined the clock, and leaves it when the line is dropped.
    pub(crate) fn new(rig: Rig, clock: Arc<dyn Clock>) -> SupervisedRig {
        let (rig, over) = (Arc::new(Mutex::new(rig)), Arc::new(AtomicBool::new(false)));
        clock.join();
        let watch = std::thread::spawn({
            let (rig, clock, over) = (Arc::clone(&rig), Arc::clone(&clock), Arc::clone(&over));
            move || {
                let _priority = clock.is_real().then(|| RealTime::new(Priority::Watch));
                while !over.load(Ordering::SeqCst) {
                    lock(&rig).poll(clock.now_s());
                    clock.sleep_until(clock.now_s() + WATCH_S);
                }
                clock.leave();
            }
        });
        SupervisedRig { rig, clock, over, watch: Some(watch) }
    }

    /// The rig, for as long as the guard lives.
    pub(crate) fn rig(&self) -> MutexGuard<'_, Rig> {
        lock(&self.rig)
    }

    /// Looks at the rig every few milliseconds until `ready` has an answer; none after `deadline_s`.
    pub(crate) fn wait<T>(&self, deadline_s: f64, mut ready: impl FnMut(&mut Rig, f64) -> Option<T>) -> Option<T> {
        loop {
            let now_s = self.clock.now_s();
            {
                let mut rig = self.rig();
                rig.poll(now_s);
                if let Some(answer) = ready(&mut rig, now_s) {
                    return Some(answer);
                }
            }
            if now_s >= deadline_s {
                return None;
            }
            self.clock.sleep_until(f64::min(now_s + WATCH_S, deadline_s));
        }
    }
}

/// A thread that panicked has not left the rig's state half changed: all of it is set before the next call.
fn lock(rig: &Mutex<Rig>) -> MutexGuard<'_, Rig> {
    rig.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for SupervisedRig {
    /// Whatever ends the program, a moving robot is held first.
    fn drop(&mut self) {
        let why = if std::thread::panicking() { "the program failed" } else { "the program ended" };
        let now_s = self.clock.now_s();
        if self.rig().shut_down(why, now_s) {
            self.wait(now_s + LEAVE_S, |rig, now_s| (!rig.shut_down(why, now_s)).then_some(()));
        }
        self.over.store(true, Ordering::SeqCst);
        self.clock.leave();
        if let Some(watch) = self.watch.take() {
            // A watch that failed has been noticed by whoever locked the rig.
            let _ = watch.join();
        }
    }
}
