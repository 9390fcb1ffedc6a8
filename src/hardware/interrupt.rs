//! Requests to end the program (signals): the robot is held, or started work is finished, before it
//! exits.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR2};
use signal_hook::flag;

/// A request to end the program.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// The request of this process: the first signal sets it, the second ends the program at once.
    ///
    /// # Errors
    /// When the system refuses the handlers.
    pub fn of_process() -> io::Result<Interrupt> {
        static OF_PROCESS: OnceLock<Interrupt> = OnceLock::new();
        if let Some(interrupt) = OF_PROCESS.get() {
            return Ok(interrupt.clone());
        }
        let interrupt = Interrupt::default();
        for signal in [SIGINT, SIGTERM] {
            // Registered first, it sees the flag as the first signal left it: the second one ends.
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&interrupt.0))?;
            flag::register(signal, Arc::clone(&interrupt.0))?;
        }
        Ok(OF_PROCESS.get_or_init(|| interrupt).clone())
    }

    /// The request of a cluster task: SIGUSR2 announces that its time is nearly over.
    ///
    /// # Errors
    /// When the system refuses the handler.
    pub fn of_batch() -> io::Result<Interrupt> {
        let interrupt = Interrupt::default();
        flag::register(SIGUSR2, Arc::clone(&interrupt.0))?;
        Ok(interrupt)
    }

    /// A flag that is true once the end has been requested.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }

    /// Requests the end of the program.
    pub fn raise(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Whether the end has been requested.
    pub fn raised(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
