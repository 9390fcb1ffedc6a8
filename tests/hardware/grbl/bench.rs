//! A driver and a fake controller on one clock that goes on only when it is told to.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard};

use spinebench::hardware::clock::Clock;
use spinebench::hardware::grbl::{Controller, MotionFault, MotionSettings};
use spinebench::hardware::serial::SerialLine;
use spinebench::simulators::{
    ControllerFault, ControllerOptions, PipeEnd, SimulatedController, pipe,
};

/// How often the fake controller is looked after, seconds.
const STEP_S: f64 = 0.005;
/// How often the driver is polled, seconds.
const POLL_S: f64 = 0.01;

/// A wire that writes down what is sent, and on which noise arrives.
struct Tap {
    serial: PipeEnd,
    sent: Arc<Mutex<Vec<u8>>>,
    noise: Arc<Mutex<VecDeque<u8>>>,
}

impl SerialLine for Tap {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut noise = self.noise.lock().unwrap();
        let count = noise.len().min(buffer.len());
        if count == 0 {
            return self.serial.read(buffer);
        }
        buffer.iter_mut().zip(noise.drain(..count)).for_each(|(place, byte)| *place = byte);
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.sent.lock().unwrap().extend(bytes);
        self.serial.write(bytes)
    }
}

struct Inside {
    now_s: f64,
    fake: SimulatedController,
    most_queued: usize,
}

/// A fake controller, its time, and what was sent to it.
pub(crate) struct Bench {
    inside: Mutex<Inside>,
    serial: Mutex<Option<PipeEnd>>,
    sent: Arc<Mutex<Vec<u8>>>,
    noise: Arc<Mutex<VecDeque<u8>>>,
}

impl Clock for Bench {
    fn now_s(&self) -> f64 {
        self.inside().now_s
    }

    fn sleep_until(&self, time_s: f64) {
        let mut inside = self.inside();
        while inside.now_s < time_s {
            inside.now_s = (inside.now_s + STEP_S).min(time_s);
            let now_s = inside.now_s;
            inside.fake.step(now_s);
            inside.most_queued = inside.most_queued.max(inside.fake.queued());
        }
    }
}

impl Bench {
    pub(crate) fn new(options: ControllerOptions) -> Bench {
        let (serial, other) = pipe();
        let mut fake = SimulatedController::new(Box::new(other), options);
        fake.step(0.0);
        let inside = Mutex::new(Inside { now_s: 0.0, fake, most_queued: 0 });
        Bench {
            inside,
            serial: Mutex::new(Some(serial)),
            sent: Arc::default(),
            noise: Arc::default(),
        }
    }

    fn inside(&self) -> MutexGuard<'_, Inside> {
        self.inside.lock().unwrap()
    }

    pub(crate) fn open_with(&self, settings: &MotionSettings) -> Result<Controller, MotionFault> {
        let serial = self.serial.lock().unwrap().take().unwrap();
        let tap = Tap { serial, sent: Arc::clone(&self.sent), noise: Arc::clone(&self.noise) };
        Controller::open(Box::new(tap), settings, self)
    }

    pub(crate) fn open(&self) -> Controller {
        self.open_with(&MotionSettings::default()).unwrap()
    }

    /// Somebody else has homed the controller before.
    pub(crate) fn home_beforehand(&self) {
        self.serial.lock().unwrap().as_mut().unwrap().write(b"$H\n").unwrap();
        self.sleep_until(self.now_s() + 8.0);
    }

    /// Discards what the controller has said before anybody listened.
    pub(crate) fn forget_received(&self) {
        let mut serial = self.serial.lock().unwrap();
        let mut buffer = [0; 1024];
        while serial.as_mut().unwrap().read(&mut buffer).unwrap() > 0 {}
    }

    /// A controller that is homed and ready for a move.
    pub(crate) fn ready(&self) -> Controller {
        self.ready_with(&MotionSettings::default())
    }

    pub(crate) fn ready_with(&self, settings: &MotionSettings) -> Controller {
        let mut controller = self.open_with(settings).unwrap();
        self.home(&mut controller).unwrap();
        self.run(&mut controller, 0.5).unwrap();
        controller
    }

    pub(crate) fn home(&self, controller: &mut Controller) -> Result<(), MotionFault> {
        controller.start_homing(self.now_s());
        assert!(controller.is_homing());
        self.run_while(controller, 70.0, Controller::is_homing)
    }

    /// Polls for this long, or until a fault.
    pub(crate) fn run(
        &self,
        controller: &mut Controller,
        duration_s: f64,
    ) -> Result<(), MotionFault> {
        self.run_while(controller, duration_s, |_| true)
    }

    /// Polls as long as `going`, but no longer than this.
    pub(crate) fn run_while(
        &self,
        controller: &mut Controller,
        most_s: f64,
        going: impl Fn(&Controller) -> bool,
    ) -> Result<(), MotionFault> {
        let end_s = self.now_s() + most_s;
        while going(controller) && self.now_s() < end_s {
            self.sleep_until(self.now_s() + POLL_S);
            controller.poll(self.now_s())?;
        }
        Ok(())
    }

    /// Sends a move, as soon as there is room for it.
    pub(crate) fn go(
        &self,
        controller: &mut Controller,
        target_mm: [f64; 4],
        feed_mm_min: f64,
    ) -> Result<(), MotionFault> {
        loop {
            match controller.move_to(target_mm, feed_mm_min, self.now_s()) {
                Err(MotionFault::Busy) => self.run(controller, POLL_S)?,
                other => return other,
            }
        }
    }

    pub(crate) fn inject(&self, fault: ControllerFault) {
        self.inside().fake.inject(fault);
    }

    /// Bytes that the driver receives besides what the controller says.
    pub(crate) fn make_noise(&self, bytes: &[u8]) {
        self.noise.lock().unwrap().extend(bytes);
    }

    pub(crate) fn clear_faults(&self) {
        self.inside().fake.clear_faults();
    }

    pub(crate) fn position_mm(&self) -> [f64; 4] {
        self.inside().fake.position_mm()
    }

    pub(crate) fn most_queued(&self) -> usize {
        self.inside().most_queued
    }

    /// Everything that was sent so far.
    pub(crate) fn sent(&self) -> Vec<u8> {
        self.sent.lock().unwrap().clone()
    }

    /// The lines that were sent so far, without realtime bytes.
    pub(crate) fn sent_lines(&self) -> Vec<String> {
        lines(&self.sent())
    }
}

/// The lines in a stream of bytes with realtime bytes between them.
pub(crate) fn lines(sent: &[u8]) -> Vec<String> {
    let text: Vec<u8> =
        sent.iter().copied().filter(|byte| !matches!(byte, b'?' | b'!' | b'~' | 0x18)).collect();
    String::from_utf8(text)
        .unwrap()
        .split('\n')
        .filter(|line| !line.is_empty())
        .map(str::to_owned)
        .collect()
}

pub(crate) fn near(one: [f64; 4], other: [f64; 4], tolerance_mm: f64) -> bool {
    one.iter().zip(other).all(|(one, other)| (one - other).abs() <= tolerance_mm)
}
