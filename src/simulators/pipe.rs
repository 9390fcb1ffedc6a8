//! Two serial lines connected to each other within the program.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::hardware::serial::SerialLine;

/// Bytes in transit in both directions, and whether both ends exist.
#[derive(Debug, Default)]
struct PipeBuffers {
    towards: [VecDeque<u8>; 2],
    cut: bool,
}

/// One end of a pipe. Dropping it unplugs the other end.
#[derive(Debug)]
pub struct PipeEnd {
    line: Arc<Mutex<PipeBuffers>>,
    end: usize,
}

/// Two connected serial lines: what is written to one is read from the other.
pub fn pipe() -> (PipeEnd, PipeEnd) {
    let line = Arc::new(Mutex::new(PipeBuffers::default()));
    (PipeEnd { line: Arc::clone(&line), end: 0 }, PipeEnd { line, end: 1 })
}

impl PipeEnd {
    /// A thread that panicked while holding the lock has left no inconsistent state.
    fn line(&self) -> MutexGuard<'_, PipeBuffers> {
        self.line.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl SerialLine for PipeEnd {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut line = self.line();
        let waiting = &mut line.towards[self.end];
        let count = waiting.len().min(buffer.len());
        for (place, byte) in buffer.iter_mut().zip(waiting.drain(..count)) {
            *place = byte;
        }
        if count == 0 && line.cut {
            return Err(unplugged());
        }
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut line = self.line();
        if line.cut {
            return Err(unplugged());
        }
        line.towards[1 - self.end].extend(bytes);
        Ok(())
    }
}

impl Drop for PipeEnd {
    fn drop(&mut self) {
        self.line().cut = true;
    }
}

fn unplugged() -> io::Error {
    io::Error::new(io::ErrorKind::BrokenPipe, "the other end is closed")
}
