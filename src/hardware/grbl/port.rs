//! The serial line as lines of text.

use std::io;

use super::parser::{LineReader, ReceivedLine};
use crate::hardware::serial::SerialLine;

/// Most bytes read at once: a controller that never stops sending may not stop the program.
const MOST_BYTES: usize = 1 << 16;

/// A wire with the beginning of the line that is still arriving.
pub(super) struct Port {
    wire: Box<dyn SerialLine>,
    reader: LineReader,
}

impl Port {
    pub(super) fn new(wire: Box<dyn SerialLine>) -> Port {
        Port { wire, reader: LineReader::default() }
    }

    /// The lines that have been completed since the last call, even when the wire has then gone.
    pub(super) fn read(&mut self) -> (Vec<ReceivedLine>, io::Result<()>) {
        let mut pieces = Vec::new();
        let mut buffer = [0; 1024];
        let mut total = 0;
        while total < MOST_BYTES {
            match self.wire.read(&mut buffer) {
                Ok(0) => break,
                Ok(count) => {
                    total += count;
                    pieces.extend(buffer.iter().take(count).filter_map(|&byte| self.reader.push(byte)));
                }
                Err(error) => return (pieces, Err(error)),
            }
        }
        (pieces, Ok(()))
    }

    /// Sends a line with the one line end that is acknowledged once.
    pub(super) fn send(&mut self, line: &str) -> io::Result<()> {
        self.wire.write(format!("{line}\n").as_bytes())
    }

    /// Sends a byte that is not part of a line.
    pub(super) fn send_byte(&mut self, byte: u8) -> io::Result<()> {
        self.wire.write(&[byte])
    }
}
