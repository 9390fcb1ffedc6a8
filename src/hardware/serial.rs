//! A serial line as a non-blocking stream of bytes.

use std::io;
use std::os::fd::AsRawFd;
use std::time::Duration;

use nix::errno::Errno;
use serialport::{SerialPort, TTYPort};

/// Bytes to and from a controller. No call blocks.
pub trait SerialLine: Send {
    /// Reads what has arrived into `buffer`; 0 if nothing has.
    ///
    /// # Errors
    /// When the line has failed (unplugged).
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize>;

    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// When the line has failed or its output buffer is full.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;
}

/// Largest number of unsent bytes: a line that accepts nothing must not block the program.
const MAX_UNSENT_BYTES: usize = 2048;

/// A serial port of this computer.
pub struct TtyLine {
    port: TTYPort,
}

impl TtyLine {
    /// Opens `path` exclusively at `baud`, eight data bits, no parity, one stop bit, no flow
    /// control.
    ///
    /// # Errors
    /// When there is no such port or another program uses it.
    pub fn open(path: &str, baud: u32) -> io::Result<TtyLine> {
        let port = serialport::new(path, baud).timeout(Duration::from_millis(1)).open_native()?;
        Ok(TtyLine { port })
    }

    /// One end of a pseudo-terminal, and the name of the other end, which programs open as a serial
    /// port.
    ///
    /// # Errors
    /// When the system has none left.
    pub fn served() -> io::Result<(TtyLine, String)> {
        let (first, second) = TTYPort::pair()?;
        // Only one program may have a port open: this process closes its own handle of the other
        // end.
        let name =
            second.name().ok_or_else(|| io::Error::other("the pseudo-terminal has no name"))?;
        Ok((TtyLine { port: first }, name))
    }

    /// Both ends of a pseudo-terminal: a serial line without a cable.
    ///
    /// # Errors
    /// When the system has none left.
    pub fn pair() -> io::Result<(TtyLine, TtyLine)> {
        let (first, second) = TTYPort::pair()?;
        Ok((TtyLine { port: first }, TtyLine { port: second }))
    }
}

impl SerialLine for TtyLine {
    /// Avoids the port's own reader, which discards data that arrived before the other end was
    /// closed.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let waiting = self.port.bytes_to_read()? as usize;
        if waiting == 0 {
            return Ok(0);
        }
        let readable = buffer.len().min(waiting);
        match nix::unistd::read(self.port.as_raw_fd(), &mut buffer[..readable]) {
            Ok(count) => Ok(count),
            Err(Errno::EAGAIN | Errno::EINTR) => Ok(0),
            Err(error) => Err(error.into()),
        }
    }

    /// Avoids the port's own writer: it asks the kernel for room first, which waits until all
    /// received data has been passed on, tens of milliseconds on a busy computer.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.port.bytes_to_write()? as usize + bytes.len() > MAX_UNSENT_BYTES {
            return Err(io::Error::new(io::ErrorKind::TimedOut, "output buffer full"));
        }
        let mut unsent = bytes;
        while !unsent.is_empty() {
            match nix::unistd::write(self.port.as_raw_fd(), unsent) {
                Ok(count) => unsent = &unsent[count..],
                Err(Errno::EINTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_before_the_other_end_closed_is_read() {
        let (mut served, name) = TtyLine::served().unwrap();
        let mut program = TtyLine::open(&name, 115_200).unwrap();
        program.write(b"!\x18").unwrap();
        drop(program);
        let mut buffer = [0; 16];
        let mut heard = Vec::new();
        let begun = std::time::Instant::now();
        while heard.len() < 2 && begun.elapsed() < Duration::from_secs(60) {
            let count = served.read(&mut buffer).unwrap();
            heard.extend_from_slice(&buffer[..count]);
            std::thread::yield_now();
        }
        assert_eq!(heard, b"!\x18");
    }
}
