//! Signals that ask the program to end: the robot is held, or what was begun is ended, before it does.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR2};
use signal_hook::flag;

/// Whether somebody has asked the program to end.
#[derive(Clone, Debug)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// One that only [`Interrupt::raise`] raises.
    pub fn new() -> Interrupt {
        Interrupt(Arc::new(AtomicBool::new(false)))
    }

    /// The one of this process: the first signal raises it, the second ends the program at once.
    ///
    /// # Errors
    /// When the system refuses the handlers.
    pub fn of_process() -> io::Result<Interrupt> {
        static OWN: OnceLock<Interrupt> = OnceLock::new();
        if let Some(own) = OWN.get() {
            return Ok(own.clone());
        }
        let interrupt = Interrupt::new();
        for signal in [SIGINT, SIGTERM] {
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&interrupt.0))?;
            flag::register(signal, Arc::clone(&interrupt.0))?;
        }
        Ok(OWN.get_or_init(|| interrupt).clone())
    }

    /// The one of a task on a cluster, which SIGUSR2 tells that its time is nearly over.
    ///
    /// # Errors
    /// When the system refuses the handler.
    pub fn of_batch() -> io::Result<Interrupt> {
        let interrupt = Interrupt::new();
        flag::register(SIGUSR2, Arc::clone(&interrupt.0))?;
        Ok(interrupt)
    }

    /// What is true once the program has been asked to end.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }

    /// Asks the program to end.
    pub fn raise(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Whether it has been asked to.
    pub fn raised(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

impl Default for Interrupt {
    fn default() -> Self {
        Interrupt::new()
    }
}
