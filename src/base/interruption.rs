//! Requests to end a long computation that nobody waits for any more.

use std::cell::RefCell;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static CURRENT: RefCell<InterruptRequest> = const { RefCell::new(InterruptRequest(None)) };
}

/// A request to end a computation. The computation looks for it at its [`interruption_point`]s and
/// unwinds there, so that the caller must catch the unwinding.
#[derive(Clone, Debug, Default)]
pub struct InterruptRequest(Option<Arc<AtomicBool>>);

/// What an interrupted computation unwinds with.
#[derive(Clone, Copy, Debug)]
pub struct Interrupted;

impl InterruptRequest {
    /// The request that is made by setting `flag`.
    pub fn of(flag: &Arc<AtomicBool>) -> InterruptRequest {
        InterruptRequest(Some(Arc::clone(flag)))
    }

    /// The request that holds for this thread: what a computation hands to other threads that work
    /// for it.
    pub fn current() -> InterruptRequest {
        CURRENT.with_borrow(InterruptRequest::clone)
    }

    /// Does `work` on this thread under this request.
    pub fn within<T>(&self, work: impl FnOnce() -> T) -> T {
        /// Puts the request before back, after unwinding, too.
        struct Before(InterruptRequest);
        impl Drop for Before {
            fn drop(&mut self) {
                CURRENT.replace(std::mem::take(&mut self.0));
            }
        }
        let _before = Before(CURRENT.replace(self.clone()));
        work()
    }

    fn is_made(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}

/// A place where the computation may end: unwinds with [`Interrupted`] where its end is requested.
pub fn interruption_point() {
    if CURRENT.with_borrow(InterruptRequest::is_made) {
        resume_unwind(Box::new(Interrupted));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::catch_unwind;

    #[test]
    fn a_computation_ends_at_its_next_point_and_others_go_on() {
        let flag = Arc::new(AtomicBool::new(false));
        let request = InterruptRequest::of(&flag);
        let mut steps = 0;
        let ended = catch_unwind(std::panic::AssertUnwindSafe(|| {
            request.within(|| {
                for step in 0..10 {
                    flag.store(step == 3, Ordering::Relaxed);
                    interruption_point();
                    steps += 1;
                }
            });
        }));
        assert!(ended.is_err_and(|payload| payload.is::<Interrupted>()));
        assert_eq!(steps, 3);
        // The request is this computation's alone.
        interruption_point();
        let inner = request.within(InterruptRequest::current);
        assert!(inner.is_made() && !InterruptRequest::current().is_made());
    }
}
