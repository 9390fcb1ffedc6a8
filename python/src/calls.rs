//! How calls run: without the interpreter's lock, over all cores, with panics as exceptions and
//! with Ctrl-C.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use spinebench::base::{InterruptRequest, Interrupted};

use crate::errors::Fault;

/// Time between looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(20);
/// Stack of a thread: solvers of long chains recurse.
const STACK_BYTES: usize = 16 << 20;

/// The threads of a process. After a fork the child has none of them and makes its own.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
/// Process that has used the library's global threads, which a forked child cannot replace; 0 for
/// none.
static GLOBAL_THREADS_OF: AtomicU32 = AtomicU32::new(0);
/// Where the last panic happened, for its exception.
static LAST_PANIC: Mutex<String> = Mutex::new(String::new());

/// Records panics for their exceptions instead of printing them.
pub(crate) fn record_panics() {
    std::panic::set_hook(Box::new(|info| {
        let place =
            info.location().map(|at| format!("{}:{}", at.file(), at.line())).unwrap_or_default();
        *LAST_PANIC.lock().unwrap_or_else(PoisonError::into_inner) = place;
    }));
}

/// The fault that a panic is.
fn panic_fault(payload: &(dyn Any + Send)) -> Fault {
    if payload.is::<Interrupted>() {
        return Fault::interrupted();
    }
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
    let place = LAST_PANIC.lock().unwrap_or_else(PoisonError::into_inner).clone();
    Fault::Panic(format!(
        "internal error at {place}: {text}; please report it with the input that led here"
    ))
}

/// The threads of this process.
pub(crate) fn pool() -> Result<Arc<ThreadPool>, Fault> {
    let mut kept = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((owner, pool)) = kept.as_ref()
        && *owner == process::id()
    {
        return Ok(Arc::clone(pool));
    }
    let made = ThreadPoolBuilder::new()
        .stack_size(STACK_BYTES)
        .thread_name(|number| format!("spinebench {number}"))
        .build()
        .map_err(|error| Fault::Run(format!("no threads could be started: {error}")))?;
    let made = Arc::new(made);
    // The threads of a parent are not joined: here they do not exist.
    if let Some(parent) = kept.replace((process::id(), Arc::clone(&made))) {
        std::mem::forget(parent);
    }
    Ok(made)
}

/// Refuses a forked child of a process that has used the library's global threads: it would wait
/// for them for ever.
pub(crate) fn claim_global_threads() -> Result<(), Fault> {
    let own = process::id();
    match GLOBAL_THREADS_OF.compare_exchange(0, own, Ordering::Relaxed, Ordering::Relaxed) {
        Ok(_) => Ok(()),
        Err(owner) if owner == own => Ok(()),
        Err(_) => Err(Fault::Run(
            "found a process forked after `spinebench.run`, expected one started with \
             multiprocessing's `spawn` or `forkserver`"
                .into(),
        )),
    }
}

/// A short call: panics become exceptions.
pub(crate) fn guarded<T>(work: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| Err(panic_fault(&*payload)))
}

/// A short call without the interpreter's lock.
pub(crate) fn detached<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Fault> + Send,
) -> PyResult<T> {
    Ok(py.detach(|| guarded(work))?)
}

/// A request to end a long call.
#[derive(Clone, Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.0
    }

    pub(crate) fn raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// A fault after the request, before anything is written.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        if self.raised() { Err(Fault::interrupted()) } else { Ok(()) }
    }

    /// Does `work`, which ends at its next interruption point after the request.
    pub(crate) fn within<T>(&self, work: impl FnOnce() -> T) -> T {
        InterruptRequest::of(&self.0).within(work)
    }
}

/// A long call: `work` runs on a thread of its own and on those of the pool, while this one looks
/// for Ctrl-C. On Ctrl-C the call returns at once; `work` ends when it next looks at the request.
pub(crate) fn long<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Stop) -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    long_watched(py, |_| Ok(()), work)
}

/// As [`long`]; this thread meanwhile asks `watch` for what there is to tell of the work.
pub(crate) fn long_watched<T: Send + 'static>(
    py: Python<'_>,
    watch: impl FnMut(Python<'_>) -> PyResult<()>,
    work: impl FnOnce(&Stop) -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    apart(py, watch, move |pool, stop| pool.install(|| guarded(|| work(stop))))
}

/// A long call on a state that calls share. The thread of its own waits for the state, not one of
/// the pool: that one may be lent out by the very call that holds the state, and would wait for
/// itself.
pub(crate) fn long_on<S: Send + 'static, T: Send + 'static>(
    py: Python<'_>,
    state: Arc<Mutex<S>>,
    work: impl FnOnce(&mut S, &Stop) -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    apart(
        py,
        |_| Ok(()),
        move |pool, stop| {
            let mut held = state.lock().unwrap_or_else(PoisonError::into_inner);
            let state = &mut *held;
            pool.install(|| guarded(|| work(state, stop)))
        },
    )
}

/// Runs on a thread of its own while this one looks for Ctrl-C and for what `watch` has to tell.
fn apart<T: Send + 'static>(
    py: Python<'_>,
    mut watch: impl FnMut(Python<'_>) -> PyResult<()>,
    work: impl FnOnce(&ThreadPool, &Stop) -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    let stop = Stop::default();
    let told = stop.clone();
    let pool = pool()?;
    let (sender, results) = channel();
    let run = move || {
        let result = work(&pool, &told);
        // Nobody waits after Ctrl-C.
        let _ = sender.send(result);
    };
    std::thread::Builder::new()
        .name("spinebench call".into())
        .stack_size(STACK_BYTES)
        .spawn(run)
        .map_err(|error| Fault::Run(format!("no thread could be started: {error}")))?;
    // A receiver alone cannot go into a call without the lock.
    let results = Mutex::new(results);
    loop {
        let received =
            py.detach(|| results.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK));
        match received {
            Ok(result) => {
                watch(py)?;
                return Ok(result?);
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Fault::Panic(
                    "internal error: the computation ended without an answer".into(),
                )
                .into());
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(interrupted) = py.check_signals().and_then(|()| watch(py)) {
                    stop.0.store(true, Ordering::Relaxed);
                    return Err(interrupted);
                }
            }
        }
    }
}
