//! The rig of one robot with its supervising thread.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use crate::hardware::clock::Clock;
use crate::hardware::realtime::{Priority, RealTime};
use crate::hardware::rig::Rig;

/// Interval at which the rig is polled, s.
const POLL_INTERVAL_S: f64 = 0.005;
/// Longest wait at the end until the robot stands and its queue is discarded, s: a late answer of
/// the controller must still arrive.
const MAX_SHUTDOWN_S: f64 = 5.0;

/// A rig that a thread of its own polls, whatever its user does.
pub(crate) struct SupervisedRig {
    rig: Arc<Mutex<Rig>>,
    pub(crate) clock: Arc<dyn Clock>,
    ended: Arc<AtomicBool>,
    watch: Option<JoinHandle<()>>,
}

impl SupervisedRig {
    /// Supervises `rig` from now on. The calling thread is registered with the clock, and
    /// deregistered on drop.
    pub(crate) fn new(rig: Rig, clock: Arc<dyn Clock>) -> SupervisedRig {
        let (rig, ended) = (Arc::new(Mutex::new(rig)), Arc::new(AtomicBool::new(false)));
        clock.join();
        let watch = std::thread::spawn({
            let (rig, clock, ended) = (Arc::clone(&rig), Arc::clone(&clock), Arc::clone(&ended));
            move || {
                let _priority = clock.is_real().then(|| RealTime::new(Priority::Supervisor));
                while !ended.load(Ordering::SeqCst) {
                    lock(&rig).poll(clock.now_s());
                    clock.sleep_until(clock.now_s() + POLL_INTERVAL_S);
                }
                clock.leave();
            }
        });
        SupervisedRig { rig, clock, ended, watch: Some(watch) }
    }

    /// The locked rig.
    pub(crate) fn rig(&self) -> MutexGuard<'_, Rig> {
        lock(&self.rig)
    }

    /// Polls the rig until `ready` returns a result; none after `deadline_s`.
    pub(crate) fn wait<T>(
        &self,
        deadline_s: f64,
        mut ready: impl FnMut(&mut Rig, f64) -> Option<T>,
    ) -> Option<T> {
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
            self.clock.sleep_until(f64::min(now_s + POLL_INTERVAL_S, deadline_s));
        }
    }
}

/// A thread that panicked has left the rig in a consistent state.
fn lock(rig: &Mutex<Rig>) -> MutexGuard<'_, Rig> {
    rig.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for SupervisedRig {
    /// However the program ends, a moving robot is held first.
    fn drop(&mut self) {
        let why = if std::thread::panicking() { "the program failed" } else { "the program ended" };
        let now_s = self.clock.now_s();
        if self.rig().shut_down(why, now_s) {
            self.wait(now_s + MAX_SHUTDOWN_S, |rig, now_s| {
                (!rig.shut_down(why, now_s)).then_some(())
            });
        }
        self.ended.store(true, Ordering::SeqCst);
        self.clock.leave();
        if let Some(watch) = self.watch.take() {
            // A panic of the supervising thread has been noticed by the next lock of the rig.
            let _ = watch.join();
        }
    }
}
