//! The same over a pseudo-terminal, which is a serial port for the driver.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use spinebench::hardware::clock::{Clock, WallClock};
use spinebench::hardware::grbl::{Controller, MotionFault, MotionSettings};
use spinebench::hardware::serial::TtyLine;
use spinebench::simulators::{ControllerOptions, SimulatedController};

/// A fake controller in a thread, until it is told to go.
struct ServedSimulator {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

fn serve(serial: TtyLine) -> ServedSimulator {
    let over = Arc::new(AtomicBool::new(false));
    let thread = std::thread::spawn({
        let over = Arc::clone(&over);
        move || {
            let clock = WallClock::new();
            let options =
                ControllerOptions { delay_s: [0.001, 0.002], ..ControllerOptions::default() };
            let mut fake = SimulatedController::new(Box::new(serial), options);
            while !over.load(Ordering::SeqCst) {
                fake.step(clock.now_s());
                std::thread::sleep(Duration::from_millis(1));
            }
        }
    });
    ServedSimulator { over, thread: Some(thread) }
}

impl ServedSimulator {
    fn unplug(&mut self) {
        self.over.store(true, Ordering::SeqCst);
        self.thread.take().map(JoinHandle::join);
    }
}

/// A busy computer is no silent controller.
fn settings() -> MotionSettings {
    MotionSettings { reply_timeout_s: 5.0, ..MotionSettings::default() }
}

#[test]
fn a_serial_line_is_opened_and_noticed_when_it_goes() {
    // Of a pseudo-terminal only the second end notices that the other one has gone.
    let (other, serial) = TtyLine::pair().unwrap();
    let mut served = serve(other);
    let clock = WallClock::new();
    let mut controller = Controller::open(Box::new(serial), &settings(), &clock).unwrap();
    assert_eq!(controller.info().firmware, "grblHAL");
    controller.poll(clock.now_s()).unwrap();
    served.unplug();
    let found =
        std::iter::repeat_with(|| controller.poll(clock.now_s())).find_map(Result::err).unwrap();
    assert!(matches!(found, MotionFault::Unplugged { .. }), "{found}");
}
