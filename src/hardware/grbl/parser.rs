//! Parser of a controller's output, line by line.

use super::state::{Mode, Pins};

/// Longest line in bytes; a longer one is not GRBL.
pub const LONGEST_LINE: usize = 256;

/// One parsed line of a controller.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply {
    /// `ok`: a line was accepted.
    Ok,
    /// `error:N`: a line was refused.
    Error(u16),
    /// `ALARM:N`: the controller has stopped.
    Alarm(u16),
    /// The greeting after a start or a reset.
    Boot(String),
    /// `<...>`: the answer to `?`.
    Status(StatusReport),
    /// `$N=value`.
    Setting {
        /// Number of the setting.
        number: u16,
        /// Its value, as written.
        value: String,
    },
    /// `[name:text]`: messages and answers to queries.
    Info {
        /// Text before the colon.
        name: String,
        /// Text after the colon.
        text: String,
    },
    /// `>...`: a start-up block and its result.
    StartupBlock(String),
}

/// A status report. Fields that a report leaves out have not changed, except for pins, which are
/// listed while active.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StatusReport {
    /// Mode of the controller.
    pub mode: Mode,
    /// A hold without a sub-state: the report does not tell whether the hold is complete.
    pub bare_hold: bool,
    /// Machine position, millimetres.
    pub position_mm: Option<[f64; 4]>,
    /// Free blocks of the motion queue.
    pub free_blocks: Option<usize>,
    /// Speed along the path, mm/min.
    pub feed_mm_min: Option<f64>,
    /// Limit switches that are closed.
    pub pins: Pins,
    /// Work offset, millimetres.
    pub offset_mm: Option<[f64; 4]>,
    /// Whether all axes are homed.
    pub homed: Option<bool>,
    /// Feed override, per cent.
    pub feed_override: Option<f64>,
}

/// Parses a line; `None` if it is not GRBL.
pub fn parse(line: &str) -> Option<Reply> {
    let line = line.trim();
    if line == "ok" {
        return Some(Reply::Ok);
    }
    if let Some(code) = line.strip_prefix("error:") {
        return code.trim().parse().ok().map(Reply::Error);
    }
    if let Some(code) = line.strip_prefix("ALARM:") {
        return code.trim().parse().ok().map(Reply::Alarm);
    }
    if line.get(..5).is_some_and(|start| {
        start.eq_ignore_ascii_case("grbl ") || start.eq_ignore_ascii_case("grblh")
    }) {
        return Some(Reply::Boot(line.to_owned()));
    }
    match line.chars().next()? {
        '<' => status(line.strip_prefix('<')?.strip_suffix('>')?).map(Reply::Status),
        '$' => setting(line.strip_prefix('$')?),
        '[' => info(line.strip_prefix('[')?.strip_suffix(']')?),
        '>' => Some(Reply::StartupBlock(line.to_owned())),
        _ => None,
    }
}

fn setting(text: &str) -> Option<Reply> {
    let (number, value) = text.split_once('=')?;
    Some(Reply::Setting { number: number.parse().ok()?, value: value.to_owned() })
}

fn info(text: &str) -> Option<Reply> {
    let (name, text) = text.split_once(':')?;
    Some(Reply::Info { name: name.to_owned(), text: text.to_owned() })
}

fn status(text: &str) -> Option<StatusReport> {
    let mut fields = text.split('|');
    let name = fields.next()?;
    let mut status =
        StatusReport { mode: mode(name)?, bare_hold: name == "Hold", ..StatusReport::default() };
    for field in fields {
        // Other fields differ between firmware versions and are ignored.
        let Some((name, value)) = field.split_once(':') else { continue };
        match name {
            "MPos" => status.position_mm = Some(four(value)?),
            "WCO" => status.offset_mm = Some(four(value)?),
            "Bf" => status.free_blocks = Some(value.split(',').next()?.parse().ok()?),
            "F" | "FS" => status.feed_mm_min = Some(number(value.split(',').next()?)?),
            "Pn" => status.pins = Pins::of_letters(value),
            "Ov" => status.feed_override = Some(number(value.split(',').next()?)?),
            "H" => status.homed = Some(value.starts_with('1')),
            _ => {}
        }
    }
    Some(status)
}

fn mode(text: &str) -> Option<Mode> {
    let (name, more) = text.split_once(':').map_or((text, None), |(name, more)| (name, Some(more)));
    Some(match name {
        "Idle" => Mode::Idle,
        "Run" => Mode::Run,
        "Hold" => Mode::Hold { complete: more == Some("0") },
        "Jog" => Mode::Jog,
        "Home" => Mode::Home,
        "Alarm" => Mode::Alarm(more.and_then(|code| code.parse().ok())),
        "Door" => Mode::Door,
        "Check" => Mode::Check,
        "Sleep" => Mode::Sleep,
        "Tool" => Mode::ToolChange,
        _ => return None,
    })
}

/// Four numbers separated by commas, one for each axis.
fn four(text: &str) -> Option<[f64; 4]> {
    let mut values = text.split(',').map(number);
    let four = [values.next()??, values.next()??, values.next()??, values.next()??];
    // A fifth axis would mean another machine.
    values.next().is_none().then_some(four)
}

fn number(text: &str) -> Option<f64> {
    let value: f64 = text.parse().ok()?;
    value.is_finite().then_some(value)
}

/// Received bytes between two line ends.
#[derive(Clone, Debug, PartialEq)]
pub enum ReceivedLine {
    /// A line in UTF-8, without its end.
    Line(String),
    /// Bytes that are not UTF-8, or too many without a line end; decoded as far as possible.
    Garbled(String),
}

/// Splits received bytes into lines.
#[derive(Clone, Debug, Default)]
pub struct LineReader {
    bytes: Vec<u8>,
    /// Inside a line that was already too long.
    overlong: bool,
}

impl LineReader {
    /// Takes the next byte; returns the line that it ends.
    pub fn push(&mut self, byte: u8) -> Option<ReceivedLine> {
        if byte == b'\n' {
            let bytes = std::mem::take(&mut self.bytes);
            // Its beginning was reported already; the rest says nothing.
            if std::mem::take(&mut self.overlong) {
                return None;
            }
            return received_line(&bytes);
        }
        self.bytes.push(byte);
        if self.bytes.len() <= LONGEST_LINE {
            return None;
        }
        // Bounded memory: noise may hold no line end at all.
        self.overlong = true;
        let bytes = std::mem::take(&mut self.bytes);
        Some(ReceivedLine::Garbled(String::from_utf8_lossy(&bytes).into_owned()))
    }

    /// The beginning of a line that cannot become one of GRBL, decoded as far as possible.
    pub fn noise(&self) -> Option<String> {
        let readable = |byte: &u8| matches!(byte, b' '..=b'~' | b'\r');
        // First characters of all lines that GRBL sends.
        let begins = self.bytes.first().is_none_or(|byte| b"<[$>oeAGg\r".contains(byte));
        let noise = !begins || !self.bytes.iter().all(readable);
        noise.then(|| String::from_utf8_lossy(&self.bytes).into_owned())
    }

    /// Discards an incomplete line.
    pub fn clear(&mut self) {
        *self = LineReader::default();
    }
}

/// A complete line; none if it is empty.
fn received_line(bytes: &[u8]) -> Option<ReceivedLine> {
    match std::str::from_utf8(bytes) {
        Ok(text) => {
            let text = text.trim_end_matches('\r');
            (!text.is_empty()).then(|| ReceivedLine::Line(text.to_owned()))
        }
        Err(_) => Some(ReceivedLine::Garbled(String::from_utf8_lossy(bytes).into_owned())),
    }
}
