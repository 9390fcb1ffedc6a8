//! A simulated GRBL controller: protocol and motion of a grblHAL with four axes, with injectable
//! faults.

mod faults;
mod gcode;
mod homing;
mod lines;
mod realtime;
mod report;
mod table;

use std::collections::{BTreeMap, VecDeque};

use rand::RngExt;

pub use faults::ControllerFault;
pub use table::{factory_settings, robot_settings};

use super::axes::SimulatedAxes;
use crate::base::{Generator, Seed};
use crate::hardware::serial::SerialLine;
use faults::ActiveFaults;
use gcode::ModalState;
use homing::HomingProgress;
use report::ReportState;
use table::Settings;

/// Capacity of the motion queue.
const MAX_QUEUED_MOVES: usize = 100;
/// Longest accepted line, bytes.
const MAX_LINE_BYTES: usize = 256;
/// Capacity of the log of received input.
const MAX_RECEIVED: usize = 1000;
/// Time step of the simulation, s.
const STEP_S: f64 = 0.01;
/// End stops lie this far beyond the switches and the travel, mm.
const END_STOP_MM: f64 = 2.0;

/// Options of a simulated controller.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerOptions {
    /// Its settings.
    pub settings: BTreeMap<u16, String>,
    /// It finds no stored settings at start-up.
    pub first_boot: bool,
    /// Initial positions of the screws, mm from home.
    pub start_mm: [f64; 4],
    /// Shortest and longest reply delay, s.
    pub delay_s: [f64; 2],
    /// Share of the status queries that are lost.
    pub lost_queries: f64,
    /// Seed of the reply delays and of lost queries.
    pub seed: u64,
    /// It behaves like plain GRBL 1.1: names neither its axes nor the homing passes, reports no
    /// homing state, orders the report fields differently, and reports holds without a sub-state.
    pub plain: bool,
}

impl Default for ControllerOptions {
    fn default() -> Self {
        ControllerOptions {
            settings: robot_settings(),
            first_boot: false,
            start_mm: [8.0, 8.0, 12.5, 12.5],
            delay_s: [0.02, 0.06],
            lost_queries: 0.005,
            seed: 0,
            plain: false,
        }
    }
}

/// Activity of the controller.
#[derive(Clone, Debug)]
enum Activity {
    /// Idle, or moving while moves are queued.
    Ready,
    Holding,
    Homing(HomingProgress),
    /// Alarm number; true if a reset is required.
    Alarm(u16, bool),
}

/// A controller at the other end of a serial line. It advances only in
/// [`SimulatedController::step`].
pub struct SimulatedController {
    serial: Option<Box<dyn SerialLine>>,
    settings: Settings,
    axes: SimulatedAxes,
    activity: Activity,
    jogging: bool,
    /// Discards all moves as soon as the axes stand.
    flushing: bool,
    homed: bool,
    modes: ModalState,
    /// Work offset, mm.
    offset_mm: [f64; 4],
    /// The error that is repeated until an empty line.
    last_error: u16,
    reporting: ReportState,
    injected: ActiveFaults,
    /// Switches that were closed in the previous step.
    closed: [bool; 4],
    partial_line: Vec<u8>,
    lines: VecDeque<Result<String, u16>>,
    received: VecDeque<String>,
    /// Replies with the times at which they are sent.
    replies: VecDeque<(f64, Vec<u8>)>,
    now_s: f64,
    started: bool,
    first_boot: bool,
    delay_s: [f64; 2],
    lost_queries: f64,
    plain: bool,
    random: Generator,
}

impl SimulatedController {
    /// A controller that starts up in its first step.
    pub fn new(serial: Box<dyn SerialLine>, options: ControllerOptions) -> SimulatedController {
        SimulatedController {
            serial: Some(serial),
            settings: options.settings,
            axes: SimulatedAxes::at(options.start_mm),
            activity: Activity::Ready,
            jogging: false,
            flushing: false,
            homed: false,
            modes: ModalState::default(),
            offset_mm: [0.0; 4],
            last_error: 0,
            reporting: ReportState::default(),
            injected: ActiveFaults::default(),
            closed: [false; 4],
            partial_line: Vec::new(),
            lines: VecDeque::new(),
            received: VecDeque::new(),
            replies: VecDeque::new(),
            now_s: 0.0,
            started: false,
            first_boot: options.first_boot,
            delay_s: options.delay_s,
            lost_queries: options.lost_queries,
            plain: options.plain,
            random: Seed(options.seed).child("controller").rng(),
        }
    }

    /// Draws the reply delays from `seed` from now on.
    pub fn reseed(&mut self, seed: Seed) {
        self.random = seed.child("controller").rng();
    }

    /// Simulates until `now_s`, s: motion, input, replies.
    pub fn step(&mut self, now_s: f64) {
        if self.started {
            self.advance_motion((now_s - self.now_s).max(0.0));
            self.now_s = self.now_s.max(now_s);
        } else {
            (self.started, self.now_s) = (true, now_s);
            self.start();
        }
        self.receive();
        self.execute_lines();
        self.send_due_replies();
    }

    /// Input since the last call, at most the last thousand entries, without status queries: lines
    /// as received; single bytes as `!` hold, `~` resume, `^X` reset and `\x..` any other.
    pub fn take_received(&mut self) -> Vec<String> {
        self.received.drain(..).collect()
    }

    fn log_received(&mut self, what: String) {
        if self.received.len() == MAX_RECEIVED {
            self.received.pop_front();
        }
        self.received.push_back(what);
    }

    /// True positions of the screws, mm from home.
    pub fn position_mm(&self) -> [f64; 4] {
        self.axes.screws_mm
    }

    /// True positions of the screws, metres from home.
    pub fn position_m(&self) -> [f64; 4] {
        self.axes.screws_mm.map(|position_mm| position_mm * 1e-3)
    }

    /// Moves in the queue, including the running one.
    pub fn queued(&self) -> usize {
        self.axes.queued()
    }

    /// Whether the controller is homed.
    pub fn homed(&self) -> bool {
        self.homed
    }

    /// Present value of a setting.
    pub fn setting(&self, number: u16) -> Option<&str> {
        self.settings.get(&number).map(String::as_str)
    }

    fn advance_motion(&mut self, duration_s: f64) {
        let mut remaining_s = duration_s;
        while remaining_s > 0.0 {
            let part_s = remaining_s.min(STEP_S);
            remaining_s -= part_s;
            self.now_s += part_s;
            match self.activity {
                _ if self.injected.has(&ControllerFault::Frozen) => {}
                Activity::Homing(_) => self.advance_homing(part_s),
                Activity::Alarm(..) => {}
                Activity::Ready | Activity::Holding => self.axes.advance(part_s),
            }
            self.jogging &= self.axes.queued() > 0;
            if self.flushing && !self.axes.is_stopping() {
                self.axes.stop();
                self.flushing = false;
            }
            self.stop_at_ends();
            self.check_switches();
        }
    }

    fn stop_at_ends(&mut self) {
        let travel_mm = table::of_axes(&self.settings, 130);
        let low_mm = -table::value(&self.settings, 27) - END_STOP_MM;
        for axis in 0..4 {
            let high_mm = (travel_mm[axis] + END_STOP_MM).max(low_mm);
            self.axes.screws_mm[axis] = self.axes.screws_mm[axis].clamp(low_mm, high_mm);
        }
    }

    /// Reads the input: real-time bytes take effect at once, lines in order.
    fn receive(&mut self) {
        let mut buffer = [0; 1024];
        loop {
            let count = match self.serial.as_mut().map(|serial| serial.read(&mut buffer)) {
                None | Some(Ok(0) | Err(_)) => return,
                Some(Ok(count)) => count,
            };
            for byte in buffer.into_iter().take(count) {
                if !self.realtime(byte) {
                    self.buffer_byte(byte);
                }
            }
        }
    }

    fn buffer_byte(&mut self, byte: u8) {
        if !matches!(byte, b'\n' | b'\r') {
            self.partial_line.push(byte);
            return;
        }
        let bytes = std::mem::take(&mut self.partial_line);
        let too_long = bytes.len() > MAX_LINE_BYTES;
        let line = String::from_utf8_lossy(&bytes).trim().to_owned();
        self.log_received(line.clone());
        self.lines.push_back(if too_long { Err(11) } else { Ok(line) });
        // Real-time bytes take effect after the lines before them, but before G-code: grblHAL reads
        // it only in its main loop.
        if !self.next_is_gcode() {
            self.execute_lines();
        }
    }

    /// Executes lines until the state requires to wait.
    fn execute_lines(&mut self) {
        while !matches!(self.activity, Activity::Homing(_))
            && self.axes.queued() < MAX_QUEUED_MOVES
            && !self.flushing
            && !self.waits_for_resume()
        {
            let Some(line) = self.lines.pop_front() else { return };
            self.execute_line(line);
        }
    }

    /// A held grblHAL leaves the G-code that it receives unread. Settings and `$` commands are
    /// answered here, for programs that find the controller held.
    fn waits_for_resume(&self) -> bool {
        matches!(self.activity, Activity::Holding) && self.next_is_gcode()
    }

    fn next_is_gcode(&self) -> bool {
        let is_gcode = |line: &Result<String, u16>| {
            line.as_ref().is_ok_and(|line| !line.is_empty() && !line.starts_with('$'))
        };
        self.lines.front().is_some_and(is_gcode)
    }

    fn reply(&mut self, text: &str) {
        self.reply_after(0.0, text);
    }

    /// Queues a reply `wait_s` later than usual.
    fn reply_after(&mut self, wait_s: f64, text: &str) {
        let [min_s, max_s] = self.delay_s;
        let delay_s = if max_s > min_s { self.random.random_range(min_s..max_s) } else { min_s };
        let due_s = self.now_s + wait_s + delay_s + self.injected.slow_s;
        // Replies keep their order.
        let due_s = self.replies.back().map_or(due_s, |(last_s, _)| last_s.max(due_s));
        for bytes in self.injected.corrupt(text) {
            self.replies.push_back((due_s, bytes));
        }
    }

    fn send_due_replies(&mut self) {
        while self.replies.front().is_some_and(|(due_s, _)| *due_s <= self.now_s) {
            let Some((_, bytes)) = self.replies.pop_front() else { return };
            if let Some(serial) = self.serial.as_mut() {
                // The other end may be closed.
                let _ = serial.write(&bytes);
            }
        }
    }
}
