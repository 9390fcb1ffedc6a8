//! Processor time of a computation, over all threads that work for it.

use std::cell::{Cell, RefCell};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

thread_local! {
    /// Where the time of other threads is added, nanoseconds.
    static ACCOUNT: RefCell<Option<Arc<AtomicU64>>> = const { RefCell::new(None) };
    /// Whether the time of this thread is being added already.
    static IS_COUNTED: Cell<bool> = const { Cell::new(false) };
}

/// Processor time of this thread, nanoseconds, from Linux's scheduler statistics (the first field);
/// 0 where the system does not tell.
pub(crate) fn thread_ns() -> u64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace().next().and_then(|field| field.parse().ok()).unwrap_or(0)
}

/// Does `work` and gives the processor time that other threads spent for it, nanoseconds, as far as
/// what they did was [`counted`].
pub(crate) fn with_time_of_others<T>(work: impl FnOnce() -> T) -> (T, u64) {
    let account = Arc::new(AtomicU64::new(0));
    let outer = ACCOUNT.replace(Some(Arc::clone(&account)));
    let result = work();
    ACCOUNT.replace(outer);
    (result, account.load(Ordering::Relaxed))
}

/// What other threads shall do for the computation of this thread: their processor time counts
/// there. Within it, the same holds for what they pass on.
pub(crate) fn counted<A, R>(work: impl Fn(A) -> R + Sync + Send) -> impl Fn(A) -> R + Sync + Send {
    let account = ACCOUNT.with_borrow(Clone::clone);
    move |argument| match &account {
        Some(account) if !IS_COUNTED.get() => {
            let _timed = TimedWork::begin(account);
            work(argument)
        }
        _ => work(argument),
    }
}

/// Work whose processor time since its beginning is added when it ends, by unwinding, too.
struct TimedWork {
    began_ns: u64,
    account: Arc<AtomicU64>,
    outer: Option<Arc<AtomicU64>>,
}

impl TimedWork {
    fn begin(account: &Arc<AtomicU64>) -> TimedWork {
        IS_COUNTED.set(true);
        let outer = ACCOUNT.replace(Some(Arc::clone(account)));
        TimedWork { began_ns: thread_ns(), account: Arc::clone(account), outer }
    }
}

impl Drop for TimedWork {
    fn drop(&mut self) {
        let spent_ns = thread_ns().saturating_sub(self.began_ns);
        self.account.fetch_add(spent_ns, Ordering::Relaxed);
        ACCOUNT.replace(self.outer.take());
        IS_COUNTED.set(false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn busy(rounds: u64) -> u64 {
        (0..rounds).fold(1, |sum, k| std::hint::black_box(sum ^ (k * sum.rotate_left(7))))
    }

    #[test]
    fn the_time_of_other_threads_counts_once() {
        let (_, alone_ns) = with_time_of_others(|| busy(1_000_000));
        assert_eq!(alone_ns, 0, "nobody else worked");
        let ((), ns) = with_time_of_others(|| {
            let inner = |rounds| counted(busy)(rounds);
            let work = counted(inner);
            std::thread::scope(|scope| {
                scope.spawn(|| work(5_000_000));
            });
        });
        let is_told = thread_ns() > 0;
        assert_eq!(ns > 0, is_told, "{ns} ns");
    }
}
