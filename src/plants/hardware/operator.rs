//! Exclusive use of the robot, and requests to the operator.

use std::io::stdin;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use crate::effects::EffectSpec;
use crate::hardware::interrupt::Interrupt;

/// Whether a part of this program uses the robot, and what is attached to it.
struct SharedRobot {
    in_use: bool,
    attached: Vec<EffectSpec>,
}

static ROBOT: Mutex<SharedRobot> = Mutex::new(SharedRobot { in_use: false, attached: Vec::new() });
static FREE: Condvar = Condvar::new();

/// Exclusive use of the robot, until it is dropped.
pub(crate) struct RobotLock(());

impl RobotLock {
    /// Waits until no other part of this program uses the robot, and has the operator attach what
    /// is missing.
    ///
    /// # Errors
    /// A message, if no operator answers.
    pub(crate) fn new(attached: &[EffectSpec]) -> Result<RobotLock, String> {
        let mut robot = ROBOT.lock().unwrap_or_else(PoisonError::into_inner);
        while robot.in_use {
            robot = FREE.wait(robot).unwrap_or_else(PoisonError::into_inner);
        }
        if robot.attached != attached {
            attach(attached)?;
            robot.attached = attached.to_vec();
        }
        robot.in_use = true;
        Ok(RobotLock(()))
    }
}

impl Drop for RobotLock {
    fn drop(&mut self) {
        ROBOT.lock().unwrap_or_else(PoisonError::into_inner).in_use = false;
        FREE.notify_one();
    }
}

/// Asks the operator to change what is attached to the robot.
fn attach(attached: &[EffectSpec]) -> Result<(), String> {
    let what = serde_json::to_string(attached).map_err(|error| error.to_string())?;
    if attached.is_empty() {
        ask_operator("remove everything from the robot")
    } else {
        ask_operator(&format!("attach to the robot: {what}"))
    }
}

/// Interval at which requests to end are checked, s.
const CHECK_INTERVAL_S: f64 = 0.05;

/// Asks the operator for an action and waits for Enter.
///
/// # Errors
/// A message, if standard input has ended or the program is interrupted.
pub fn ask_operator(what: &str) -> Result<(), String> {
    let interrupt = Interrupt::of_process().map_err(|error| error.to_string())?;
    eprint!("{what}, then press Enter: ");
    let (sender, answer) = channel();
    // A signal does not interrupt the reading of a line, so another thread reads it.
    std::thread::spawn(move || {
        let mut line = String::new();
        // The receiver may be gone.
        let _ = sender.send(matches!(stdin().read_line(&mut line), Ok(count) if count > 0));
    });
    loop {
        match answer.recv_timeout(Duration::from_secs_f64(CHECK_INTERVAL_S)) {
            Ok(true) => return Ok(()),
            Err(RecvTimeoutError::Timeout) if !interrupt.raised() => {}
            Err(RecvTimeoutError::Timeout) => {
                return Err(format!("interrupted while waiting for the operator: {what}"));
            }
            Ok(false) | Err(RecvTimeoutError::Disconnected) => {
                return Err(format!("stdin closed while waiting for the operator: {what}"));
            }
        }
    }
}
