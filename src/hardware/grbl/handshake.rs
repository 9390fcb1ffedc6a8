//! Handshake: identifies the controller and checks its settings. Moves nothing.

use super::check;
use super::check::SettingsTable;
use super::fault::MotionFault;
use super::gcode::{FULL_REPORT, RESET};
use super::parser::{ReceivedLine, Reply, StatusReport, parse};
use super::port::Port;
use super::settings::MotionSettings;
use super::state::{HOMING_REQUIRED, Mode};
use crate::hardware::clock::Clock;

/// Longest start-up time of a controller after its port is opened, s.
const START_UP_S: f64 = 5.0;
/// Interval at which the line is read, s.
const READ_INTERVAL_S: f64 = 0.005;
/// Longest duration of moves left over by another program, s, and the interval of queries during
/// that time.
const LEFTOVER_MOVES_S: f64 = 2.0;
/// See [`LEFTOVER_MOVES_S`].
const QUERY_INTERVAL_S: f64 = 0.05;
/// Longest silence that is waited for before the first query, s.
const SILENCE_S: f64 = 1.0;
/// Times that the status is queried before the controller counts as silent.
const QUERIES: usize = 3;
/// Unreadable lines after which no answer is expected any more.
const MAX_GARBLED: usize = 3;

/// What a controller said about itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControllerInfo {
    /// Version of the firmware, such as `1.1f.20260817:`.
    pub version: String,
    /// Name of the firmware, such as `grblHAL`; empty when it gives none.
    pub firmware: String,
    /// Capacity of its motion queue, moves.
    pub blocks: usize,
    /// Greatest speed of each axis, mm/min.
    pub max_speed_mm_min: [f64; 4],
    /// Greatest acceleration of each axis, mm/s².
    pub acceleration_mm_s2: [f64; 4],
    /// Travel of each axis, mm.
    pub travel_mm: [f64; 4],
    /// All its settings by number.
    pub settings: SettingsTable,
}

/// Identifies the controller at `port`; returns its latest status as well.
pub(super) fn identify_controller(
    port: &mut Port,
    settings: &MotionSettings,
    clock: &dyn Clock,
) -> Result<(ControllerInfo, StatusReport), MotionFault> {
    let timeout_s = settings.reply_timeout_s;
    let mut handshake = Handshake { port, clock, timeout_s, pushed_alarm: Mode::Unknown };
    // A controller that restarts when its port is opened, or is reset, may do so during the
    // handshake.
    for _ in 0..2 {
        match handshake.identify(settings) {
            Err(MotionFault::Rebooted { .. }) => {}
            other => return other,
        }
    }
    handshake.identify(settings)
}

struct Handshake<'a> {
    port: &'a mut Port,
    clock: &'a dyn Clock,
    timeout_s: f64,
    /// The last alarm that the controller has pushed: a status report may leave out its number.
    pushed_alarm: Mode,
}

impl Handshake<'_> {
    fn identify(
        &mut self,
        settings: &MotionSettings,
    ) -> Result<(ControllerInfo, StatusReport), MotionFault> {
        // 1. End what another program left behind.
        self.wake()?;
        // 2. Wait until nothing moves.
        let first = self.wait_until_standing()?;
        if !matches!(first.mode, Mode::Idle | Mode::Alarm(_)) {
            return Err(MotionFault::UnexpectedMode { mode: first.mode });
        }
        // 3. Firmware, settings and offsets, before any line that could move.
        let mut info = parse_identity(&self.query("$I")?, first.free_blocks)?;
        info.settings = settings_table(&self.query("$$")?);
        check::check(&info.settings, settings)?;
        check_offsets(&self.query("$#")?)?;
        let numbers = |first: u16| {
            [0, 1, 2, 3].map(|axis| check::number(&info.settings, first + axis).unwrap_or(0.0))
        };
        (info.max_speed_mm_min, info.acceleration_mm_s2, info.travel_mm) =
            (numbers(110), numbers(120), numbers(130));
        // Reports leave out values that have been reported before.
        let mut last = self.status()?;
        if last.mode == Mode::Alarm(None) {
            last.mode = self.alarm_mode()?;
        }
        last.homed = last.homed.or(first.homed);
        Ok((info, last))
    }

    /// Waits until nothing moves. A program that was killed leaves at most two moves, which end by
    /// themselves. One that held the robot may leave them waiting: a reset discards them, and axes
    /// at rest keep their position.
    fn wait_until_standing(&mut self) -> Result<StatusReport, MotionFault> {
        let began_s = self.clock.now_s();
        let mut before_mm = None;
        loop {
            let status = self.status()?;
            // A hold without a sub-state is complete once two reports agree.
            let stood = std::mem::replace(&mut before_mm, status.position_mm) == status.position_mm;
            let mode =
                if status.bare_hold && stood { Mode::Hold { complete: true } } else { status.mode };
            match mode {
                Mode::Run | Mode::Hold { complete: false }
                    if self.clock.now_s() - began_s < LEFTOVER_MOVES_S =>
                {
                    self.clock.sleep_until(self.clock.now_s() + QUERY_INTERVAL_S);
                }
                Mode::Hold { complete: true } => {
                    self.port.send_byte(RESET).map_err(|error| MotionFault::unplugged(&error))?;
                    return Err(MotionFault::Rebooted {
                        greeting: "reset during a hold".to_owned(),
                    });
                }
                _ => return Ok(status),
            }
        }
    }

    /// Ends an incomplete line and a repeating error, then waits until no old output arrives.
    fn wake(&mut self) -> Result<(), MotionFault> {
        let began_s = self.clock.now_s();
        let mut garbled = Vec::new();
        loop {
            // GRBL acknowledges an empty line, and moves nothing.
            self.send("")?;
            if self.wait_for_ok(&mut garbled)? {
                return self.drain();
            }
            let waited_s = self.clock.now_s() - began_s;
            if waited_s <= START_UP_S {
                continue;
            }
            return Err(self.no_answer("an empty line", waited_s, &garbled));
        }
    }

    /// Waits for an `ok`; false if none arrives in time.
    fn wait_for_ok(&mut self, garbled: &mut Vec<String>) -> Result<bool, MotionFault> {
        let until_s = self.clock.now_s() + self.timeout_s.max(0.5);
        while self.clock.now_s() < until_s {
            for received in self.read_lines()? {
                match parse_received(received) {
                    Ok(Reply::Ok) => return Ok(true),
                    Ok(_) => {}
                    Err(line) => garbled.push(line),
                }
            }
        }
        Ok(false)
    }

    fn drain(&mut self) -> Result<(), MotionFault> {
        let mut quiet_s = self.clock.now_s();
        let end_s = quiet_s + START_UP_S;
        // A controller that never falls silent must not keep the program here.
        while self.clock.now_s().min(end_s) < (quiet_s + self.timeout_s.min(SILENCE_S)).min(end_s) {
            if !self.read_lines()?.is_empty() {
                quiet_s = self.clock.now_s();
            }
        }
        Ok(())
    }

    /// Sends `question` and returns the lines before its `ok`.
    fn query(&mut self, question: &str) -> Result<Vec<Reply>, MotionFault> {
        self.send(question)?;
        let mut answers = Vec::new();
        self.wait_for(question, |reply| match reply {
            Reply::Ok => Some(Ok(())),
            Reply::Error(code) => Some(Err(MotionFault::Error { code, line: question.to_owned() })),
            other => {
                answers.push(other);
                None
            }
        })?;
        Ok(answers)
    }

    /// Queries the status; a query that is lost is sent again.
    fn status(&mut self) -> Result<StatusReport, MotionFault> {
        let mut answer = self.query_status();
        for _ in 1..QUERIES {
            if !matches!(answer, Err(MotionFault::Silent { .. })) {
                break;
            }
            answer = self.query_status();
        }
        answer
    }

    /// The mode of a controller whose reports leave out the number of its alarm, which was raised
    /// before it was connected: grblHAL names it in a full report, other firmware does not answer.
    fn alarm_mode(&mut self) -> Result<Mode, MotionFault> {
        match self.query_report(FULL_REPORT) {
            Ok(status) => Ok(status.mode),
            Err(MotionFault::Silent { .. }) => Ok(Mode::Alarm(None)),
            Err(fault) => Err(fault),
        }
    }

    fn query_status(&mut self) -> Result<StatusReport, MotionFault> {
        self.query_report(b'?')
    }

    /// Asks for a status report with the real-time byte `query`.
    fn query_report(&mut self, query: u8) -> Result<StatusReport, MotionFault> {
        self.port.send_byte(query).map_err(|error| MotionFault::unplugged(&error))?;
        self.wait_for("a status query", |reply| match reply {
            Reply::Status(status) if status.position_mm.is_some() => Some(Ok(status)),
            Reply::Status(_) => Some(Err(MotionFault::no_position())),
            _ => None,
        })
        .map(|status| StatusReport { mode: status.mode.with_alarm_of(self.pushed_alarm), ..status })
    }

    /// The fault for an answer that has not arrived. An unreadable line may have been the answer.
    fn no_answer(&self, to: &str, waited_s: f64, garbled: &[String]) -> MotionFault {
        let to = to.to_owned();
        match (garbled.last(), self.port.noise()) {
            (Some(line), _) => MotionFault::Garbled { count: garbled.len(), line: line.clone() },
            (None, Some(line)) => MotionFault::Noise { to, line, waited_s },
            (None, None) => MotionFault::Silent { to, waited_s },
        }
    }

    /// Passes every reply to `accept` until it returns a result; every received line extends the
    /// deadline.
    fn wait_for<T>(
        &mut self,
        question: &str,
        mut accept: impl FnMut(Reply) -> Option<Result<T, MotionFault>>,
    ) -> Result<T, MotionFault> {
        let began_s = self.clock.now_s();
        let (mut last_s, mut garbled) = (began_s, Vec::new());
        while self.clock.now_s() - last_s <= self.timeout_s
            && self.clock.now_s() - began_s <= START_UP_S
        {
            for received in self.read_lines()? {
                // Long answers, such as `$$`, take longer than one reply.
                last_s = self.clock.now_s();
                match parse_received(received) {
                    Ok(Reply::Boot(greeting)) => return Err(MotionFault::Rebooted { greeting }),
                    Ok(Reply::Alarm(code)) if code != HOMING_REQUIRED => {
                        return Err(MotionFault::Alarm { code });
                    }
                    Ok(reply) => {
                        if let Some(result) = accept(reply) {
                            return result;
                        }
                    }
                    Err(line) => garbled.push(line),
                }
            }
            // A wrong baud rate gives nothing else: no need to wait.
            if garbled.len() >= MAX_GARBLED {
                break;
            }
        }
        Err(self.no_answer(question, self.clock.now_s() - began_s, &garbled))
    }

    /// Waits briefly and returns the lines that have arrived.
    fn read_lines(&mut self) -> Result<Vec<ReceivedLine>, MotionFault> {
        self.clock.sleep_until(self.clock.now_s() + READ_INTERVAL_S);
        let (received_lines, gone) = self.port.read();
        gone.map_err(|error| MotionFault::unplugged(&error))?;
        for received in &received_lines {
            let ReceivedLine::Line(line) = received else { continue };
            match parse(line) {
                Some(Reply::Alarm(code)) => self.pushed_alarm = Mode::Alarm(Some(code)),
                // What was pushed before a restart is over.
                Some(Reply::Boot(_)) => self.pushed_alarm = Mode::Unknown,
                _ => {}
            }
        }
        Ok(received_lines)
    }

    fn send(&mut self, line: &str) -> Result<(), MotionFault> {
        self.port.send(line).map_err(|error| MotionFault::unplugged(&error))
    }
}

/// Parses a received line; returns the line itself if it is not GRBL.
fn parse_received(received: ReceivedLine) -> Result<Reply, String> {
    match received {
        ReceivedLine::Line(line) => parse(&line).ok_or(line),
        ReceivedLine::Garbled(line) => Err(line),
    }
}

/// Refuses anything but GRBL 1.1 with axes X, Y, Z and A. `free_blocks` blocks of its queue were
/// free at rest.
fn parse_identity(
    answers: &[Reply],
    free_blocks: Option<usize>,
) -> Result<ControllerInfo, MotionFault> {
    let field = |key: &str| {
        answers.iter().find_map(|reply| match reply {
            Reply::Info { name, text } if name == key => Some(text.clone()),
            _ => None,
        })
    };
    let version = field("VER").unwrap_or_default();
    if !version.starts_with("1.1") {
        return Err(MotionFault::WrongFirmware {
            what: "version",
            found: version,
            expected: "GRBL 1.1 or grblHAL",
        });
    }
    // Firmware that does not name its axes has reported four positions.
    if let Some(axes) = field("AXS").filter(|axes| axes != "4:XYZA") {
        return Err(MotionFault::WrongFirmware { what: "axes", found: axes, expected: "4:XYZA" });
    }
    let reported = field("OPT").and_then(|options| options.split(',').nth(1)?.trim().parse().ok());
    // Without either, moves count as done when the controller reports `Idle`.
    let blocks = reported.or(free_blocks).unwrap_or(0);
    Ok(ControllerInfo {
        version,
        firmware: field("FIRMWARE").unwrap_or_default(),
        blocks,
        ..ControllerInfo::default()
    })
}

fn settings_table(answers: &[Reply]) -> SettingsTable {
    let settings = answers.iter().filter_map(|reply| match reply {
        Reply::Setting { number, value } => Some((*number, value.clone())),
        _ => None,
    });
    settings.collect()
}

/// Offsets that shift the meaning of `G1`, and the commands that clear them.
const OFFSETS: [(&str, &str); 3] =
    [("G54", "G10 L2 P1 X0 Y0 Z0 A0"), ("G92", "G92.1"), ("TLO", "G49")];

fn check_offsets(answers: &[Reply]) -> Result<(), MotionFault> {
    for reply in answers {
        let Reply::Info { name, text } = reply else { continue };
        let Some((_, remedy)) = OFFSETS.iter().find(|(offset, _)| offset == name) else { continue };
        // Some firmware reports the tool length offset as one number.
        let shifted = |value: &str| value.trim().parse().is_ok_and(|value: f64| value != 0.0);
        if text.split(',').any(shifted) {
            return Err(MotionFault::WorkOffset {
                name: name.clone(),
                found: text.clone(),
                remedy: (*remedy).to_owned(),
            });
        }
    }
    Ok(())
}
