//! One robot, one user at a time, and the things that only hands can do to it.

use std::io::stdin;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use crate::effects::EffectSpec;
use crate::hardware::interrupt::Interrupt;

/// Whether somebody in this program has the robot, and what hangs on it.
struct SharedRobot {
    taken: bool,
    attached: Vec<EffectSpec>,
}

static ROBOT: Mutex<SharedRobot> = Mutex::new(SharedRobot { taken: false, attached: Vec::new() });
static FREE: Condvar = Condvar::new();

/// The right to use the robot, until it is dropped.
pub(crate) struct RobotLock(());

impl RobotLock {
    /// Waits until nobody else in this program has the robot, and has it changed if it has to be.
    ///
    /// # Errors
    /// In words, when there is nobody who could change it.
    pub(crate) fn new(attached: &[EffectSpec]) -> Result<RobotLock, String> {
        let mut robot = ROBOT.lock().unwrap_or_else(PoisonError::into_inner);
        while robot.taken {
            robot = FREE.wait(robot).unwrap_or_else(PoisonError::into_inner);
        }
        if robot.attached != attached {
            attach(attached)?;
            robot.attached = attached.to_vec();
        }
        robot.taken = true;
        Ok(RobotLock(()))
    }
}

impl Drop for RobotLock {
    fn drop(&mut self) {
        ROBOT.lock().unwrap_or_else(PoisonError::into_inner).taken = false;
        FREE.notify_one();
    }
}

/// Asks for the robot to be changed and waits until somebody says that it has been.
fn attach(attached: &[EffectSpec]) -> Result<(), String> {
    let what = serde_json::to_string(attached).map_err(|error| error.to_string())?;
    if attached.is_empty() {
        ask_operator("take everything off the robot")
    } else {
        ask_operator(&format!("attach to the robot: {what}"))
    }
}

/// How often a request to end is looked for, s.
const LOOK_S: f64 = 0.05;

/// Asks for what only hands can do and waits until somebody presses Enter.
///
/// # Errors
/// In words, when there is nobody (standard input has ended) or the program is to end.
pub fn ask_operator(what: &str) -> Result<(), String> {
    let interrupt = Interrupt::of_process().map_err(|error| error.to_string())?;
    eprint!("{what}, then press Enter: ");
    let (sender, answer) = channel();
    // A signal does not end the reading of a line, so that somebody else has to do it.
    std::thread::spawn(move || {
        let mut line = String::new();
        // Whoever asked may have gone.
        let _ = sender.send(matches!(stdin().read_line(&mut line), Ok(count) if count > 0));
    });
    loop {
        match answer.recv_timeout(Duration::from_secs_f64(LOOK_S)) {
            Ok(true) => return Ok(()),
            Err(RecvTimeoutError::Timeout) if !interrupt.raised() => {}
            Err(RecvTimeoutError::Timeout) => return Err(format!("interrupted before this was done: {what}")),
            Ok(false) | Err(RecvTimeoutError::Disconnected) => {
                return Err(format!("nobody there to do this: {what}"));
            }
        }
    }
}
