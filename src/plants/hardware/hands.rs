//! One robot, one user at a time, and the things that only hands can do to it.

use std::io::{BufRead, stdin};
use std::sync::{Condvar, Mutex, PoisonError};

use crate::effects::EffectSpec;

/// Whether somebody in this program has the robot, and what hangs on it.
struct Bench {
    taken: bool,
    attached: Vec<EffectSpec>,
}

static BENCH: Mutex<Bench> = Mutex::new(Bench { taken: false, attached: Vec::new() });
static FREE: Condvar = Condvar::new();

/// The right to use the robot, until it is dropped.
pub(super) struct Claim(());

impl Claim {
    /// Waits until nobody else in this program has the robot, and has it changed if it has to be.
    ///
    /// # Errors
    /// In words, when there is nobody who could change it.
    pub(super) fn new(attached: &[EffectSpec]) -> Result<Claim, String> {
        let mut bench = BENCH.lock().unwrap_or_else(PoisonError::into_inner);
        while bench.taken {
            bench = FREE.wait(bench).unwrap_or_else(PoisonError::into_inner);
        }
        if bench.attached != attached {
            ask(attached)?;
            bench.attached = attached.to_vec();
        }
        bench.taken = true;
        Ok(Claim(()))
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        BENCH.lock().unwrap_or_else(PoisonError::into_inner).taken = false;
        FREE.notify_one();
    }
}

/// Asks for the robot to be changed and waits until somebody says that it has been.
fn ask(attached: &[EffectSpec]) -> Result<(), String> {
    let what = serde_json::to_string(attached).map_err(|error| error.to_string())?;
    let words = if attached.is_empty() {
        "take everything off the robot".to_owned()
    } else {
        format!("attach to the robot: {what}")
    };
    eprint!("{words}, then press Enter: ");
    let mut line = String::new();
    match stdin().lock().read_line(&mut line) {
        Ok(count) if count > 0 => Ok(()),
        _ => Err(format!("nobody there to do this: {words}")),
    }
}
