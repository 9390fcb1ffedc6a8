//! Words for whoever ends a long command by Ctrl-C.

use spinebench::hardware::interrupt::Interrupt;
use std::time::Duration;

/// Time between looks at the request to end.
const POLL_PERIOD: Duration = Duration::from_millis(20);
/// Exit status of a program that was ended by SIGINT.
const SIGINT_STATUS: i32 = 130;

/// From now on the first Ctrl-C (or SIGTERM) ends the process with these words, at once: whoever
/// calls this keeps nothing half-written. A system that refuses the handlers ends it without words.
pub(crate) fn exit_on_interrupt(words: &'static str) {
    exit_on_interrupt_after(words, || ());
}

/// The same, after `clean_up`.
pub(crate) fn exit_on_interrupt_after(
    words: &'static str,
    clean_up: impl FnOnce() + Send + 'static,
) {
    let Ok(interrupt) = Interrupt::of_process() else { return };
    let watch = move || {
        while !interrupt.raised() {
            std::thread::sleep(POLL_PERIOD);
        }
        clean_up();
        eprintln!("\n{words}");
        std::process::exit(SIGINT_STATUS);
    };
    // Without a thread for it, the second Ctrl-C ends the process.
    drop(std::thread::Builder::new().name("interrupt".into()).spawn(watch));
}
