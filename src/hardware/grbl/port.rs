//! The serial line as lines of text.

use std::io;

use super::parser::{LineReader, ReceivedLine};
use crate::hardware::serial::SerialLine;

/// Most bytes read in one call, so that a controller that never stops sending cannot block the
/// program.
const MAX_BYTES: usize = 1 << 16;

/// A serial line with the incomplete line that is still arriving.
pub(super) struct Port {
    serial: Box<dyn SerialLine>,
    reader: LineReader,
}

impl Port {
    pub(super) fn new(serial: Box<dyn SerialLine>) -> Port {
        Port { serial, reader: LineReader::default() }
    }

    /// The lines completed since the last call, even if the serial line has failed since.
    pub(super) fn read(&mut self) -> (Vec<ReceivedLine>, io::Result<()>) {
        let mut received_lines = Vec::new();
        let mut buffer = [0; 1024];
        let mut total = 0;
        while total < MAX_BYTES {
            match self.serial.read(&mut buffer) {
                Ok(0) => break,
                Ok(count) => {
                    total += count;
                    received_lines.extend(
                        buffer.iter().take(count).filter_map(|&byte| self.reader.push(byte)),
                    );
                }
                Err(error) => return (received_lines, Err(error)),
            }
        }
        (received_lines, Ok(()))
    }

    /// The beginning of a line that cannot become one of GRBL, decoded as far as possible.
    pub(super) fn noise(&self) -> Option<String> {
        self.reader.noise()
    }

    /// Sends a line with exactly one line end, so that it is acknowledged once.
    pub(super) fn send(&mut self, line: &str) -> io::Result<()> {
        self.serial.write(format!("{line}\n").as_bytes())
    }

    /// Sends a real-time byte, which is not part of a line.
    pub(super) fn send_byte(&mut self, byte: u8) -> io::Result<()> {
        self.serial.write(&[byte])
    }
}
