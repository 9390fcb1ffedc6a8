//! Another program that answers each request, a line of JSON, with one line of JSON: a process on
//! its standard input and output, or a server on a loopback port.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde::Serialize;
use serde_json::Value;

/// Longest line that is read, bytes: a program that sends more is faulty.
const MAX_LINE_BYTES: u64 = 1 << 20;
/// How much of a process's error output is kept, bytes.
const KEPT_ERROR_BYTES: usize = 2048;
/// How long a process may take to end after its input has closed.
const END_S: f64 = 2.0;

/// Why another program gave no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PeerError {
    /// It cannot be started or reached.
    #[error("{0}")]
    Unreachable(String),
    /// It gave no answer in time.
    #[error("late: no answer within {limit_s} s")]
    Late {
        /// The limit, seconds.
        limit_s: f64,
    },
    /// It ended: how, and the last line of its error output.
    #[error("ended: {0}")]
    Ended(String),
    /// Its answer is no line of JSON.
    #[error("not a line of JSON: {0}")]
    NoJson(String),
}

/// The other program. Dropping it ends a process that was started.
pub struct LinePeer {
    child: Option<Child>,
    requests: Option<Box<dyn Write + Send>>,
    answers: Receiver<std::io::Result<Vec<u8>>>,
    error_output: Arc<Mutex<Vec<u8>>>,
    error_reader: Option<JoinHandle<()>>,
}

impl LinePeer {
    /// Starts a process.
    ///
    /// # Errors
    /// [`PeerError::Unreachable`] where it cannot be started.
    pub fn start(command: &[String]) -> Result<LinePeer, PeerError> {
        let [program, arguments @ ..] = command else {
            return Err(PeerError::Unreachable("an empty command".to_owned()));
        };
        let mut process = Command::new(program);
        process.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = process
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| PeerError::Unreachable(format!("{program}: {error}")))?;
        let error_output = Arc::new(Mutex::new(Vec::new()));
        let error_reader = child.stderr.take().map(|stderr| {
            let kept = Arc::clone(&error_output);
            std::thread::spawn(move || keep_end(stderr, &kept))
        });
        let requests = child.stdin.take().map(|stdin| Box::new(stdin) as Box<dyn Write + Send>);
        let stdout = child.stdout.take().map(|stdout| Box::new(stdout) as Box<dyn Read + Send>);
        let answers = read_lines(stdout.unwrap_or_else(|| Box::new(std::io::empty())));
        Ok(LinePeer { child: Some(child), requests, answers, error_output, error_reader })
    }

    /// Connects to a server on this machine.
    ///
    /// # Errors
    /// [`PeerError::Unreachable`] where it cannot be reached within `limit_s` seconds.
    pub fn connect(address: SocketAddr, limit_s: f64) -> Result<LinePeer, PeerError> {
        let limit = duration(limit_s);
        let connected = TcpStream::connect_timeout(&address, limit).and_then(|stream| {
            stream.set_nodelay(true)?;
            Ok((stream.try_clone()?, stream))
        });
        let (reading, writing) =
            connected.map_err(|error| PeerError::Unreachable(format!("{address}: {error}")))?;
        Ok(LinePeer {
            child: None,
            requests: Some(Box::new(writing)),
            answers: read_lines(Box::new(reading)),
            error_output: Arc::default(),
            error_reader: None,
        })
    }

    /// Sends a request and waits for its answer, at most `limit_s` seconds.
    ///
    /// # Errors
    /// [`PeerError`] without an answer in time.
    pub fn ask(&mut self, request: &impl Serialize, limit_s: f64) -> Result<Value, PeerError> {
        if let Ok(unasked) = self.answers.try_recv() {
            return match unasked {
                Ok(line) if !line.is_empty() => Err(PeerError::NoJson(format!(
                    "a line without a request: {}",
                    shortened(&line)
                ))),
                _ => Err(self.ended()),
            };
        }
        let mut line =
            serde_json::to_vec(request).map_err(|error| PeerError::NoJson(error.to_string()))?;
        line.push(b'\n');
        let sent = self
            .requests
            .as_mut()
            .map(|requests| requests.write_all(&line).and_then(|()| requests.flush()));
        if !matches!(sent, Some(Ok(()))) {
            return Err(self.ended());
        }
        match self.answers.recv_timeout(duration(limit_s)) {
            Ok(Ok(line)) if !line.is_empty() => {
                serde_json::from_slice(&line).map_err(|_| PeerError::NoJson(shortened(&line)))
            }
            Ok(_) | Err(RecvTimeoutError::Disconnected) => Err(self.ended()),
            Err(RecvTimeoutError::Timeout) => Err(PeerError::Late { limit_s }),
        }
    }

    /// Sends a last request, to which no answer is read, and closes the connection.
    pub fn say_goodbye(&mut self, request: &impl Serialize) {
        if let (Some(requests), Ok(mut line)) = (&mut self.requests, serde_json::to_vec(request)) {
            line.push(b'\n');
            // A program that has ended already needs no goodbye.
            let _ = requests.write_all(&line).and_then(|()| requests.flush());
        }
        self.requests = None;
        self.wait();
    }

    /// Waits for the end of the process; its status where it ends in time.
    fn wait(&mut self) -> Option<ExitStatus> {
        let child = self.child.as_mut()?;
        let began = Instant::now();
        while began.elapsed().as_secs_f64() < END_S {
            if let Ok(Some(status)) = child.try_wait() {
                return Some(status);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        None
    }

    /// Waits until the error output of a process that ended is read, at most for a moment: a process
    /// that it has started may hold it open.
    fn read_error_output(&self) {
        let began = Instant::now();
        while !self.error_reader.as_ref().is_none_or(JoinHandle::is_finished)
            && began.elapsed().as_secs_f64() < END_S
        {
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn ended(&mut self) -> PeerError {
        self.requests = None;
        let mut words = match self.wait() {
            Some(status) => describe(status),
            None if self.child.is_some() => "it closed its output".to_owned(),
            None => "the connection is closed".to_owned(),
        };
        self.read_error_output();
        let kept = self.error_output.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) =
            String::from_utf8_lossy(&kept).lines().rev().find(|line| !line.trim().is_empty())
        {
            let _ = write!(words, " ({})", printable(last.trim(), 200));
        }
        PeerError::Ended(words)
    }
}

impl Drop for LinePeer {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            // It may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Hands on line by line what is read. An empty line stands for a line that is too long.
fn read_lines(from: Box<dyn Read + Send>) -> Receiver<std::io::Result<Vec<u8>>> {
    // One answer waits at most: a program that floods its output is held up.
    let (sender, receiver) = sync_channel(1);
    std::thread::spawn(move || {
        let mut reader = BufReader::new(from);
        loop {
            let mut line = Vec::new();
            let read = (&mut reader).take(MAX_LINE_BYTES).read_until(b'\n', &mut line);
            let goes_on = matches!(read, Ok(count) if count > 0) && line.ends_with(b"\n");
            if !goes_on {
                line.clear();
            }
            if sender.send(read.map(|_| line)).is_err() || !goes_on {
                return;
            }
        }
    });
    receiver
}

/// Keeps the end of what is read.
fn keep_end(mut from: impl Read, kept: &Mutex<Vec<u8>>) {
    let mut piece = [0; 1024];
    while let Ok(count @ 1..) = from.read(&mut piece) {
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.extend_from_slice(&piece[..count]);
        let excess = kept.len().saturating_sub(KEPT_ERROR_BYTES);
        kept.drain(..excess);
    }
}

fn shortened(line: &[u8]) -> String {
    printable(String::from_utf8_lossy(line).trim_end(), 80)
}

/// The beginning of a text from another program, at most so many letters, without control characters.
pub(crate) fn printable(text: &str, letters: usize) -> String {
    text.chars().filter(|letter| !letter.is_control()).take(letters).collect()
}

/// A time limit, 30 years at most; without time where it is negative.
fn duration(limit_s: f64) -> Duration {
    const MAX_S: f64 = 1e9;
    Duration::try_from_secs_f64(limit_s.min(MAX_S)).unwrap_or_default()
}

/// How a process ended, in words.
fn describe(status: ExitStatus) -> String {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        // Numbers of signals as on Linux, x86 and ARM alike.
        match status.signal() {
            Some(31) => return "forbidden system call".to_owned(),
            Some(24) => return "limit of processor time".to_owned(),
            Some(9) => return "killed".to_owned(),
            Some(signal) => return format!("signal {signal}"),
            None => {}
        }
    }
    status.code().map_or_else(|| "killed".to_owned(), |code| format!("exit status {code}"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use serde_json::json;

    fn shell(script: &str) -> LinePeer {
        LinePeer::start(&["sh".to_owned(), "-c".to_owned(), script.to_owned()]).unwrap()
    }

    #[test]
    fn each_request_gets_the_next_line() {
        let mut peer = shell("while read -r line; do echo \"[$line]\"; done");
        for number in 0..3 {
            assert_eq!(peer.ask(&json!({ "n": number }), 5.0).unwrap(), json!([{ "n": number }]));
        }
    }

    #[test]
    fn what_gives_no_answer_is_named() {
        let asked = |script: &str, limit_s| shell(script).ask(&json!(1), limit_s).unwrap_err();
        assert_eq!(asked("sleep 5", 0.05), PeerError::Late { limit_s: 0.05 });
        assert_eq!(asked("read -r line; echo no", 5.0), PeerError::NoJson("no".to_owned()));
        let ended = asked("echo 'it fails' >&2; exit 3", 5.0);
        assert_eq!(ended, PeerError::Ended("exit status 3 (it fails)".to_owned()));
        assert_eq!(asked("kill -31 $$", 5.0), PeerError::Ended("forbidden system call".to_owned()));
        let flood = asked("read -r line; yes | tr -d '\\n'", 5.0);
        assert!(matches!(flood, PeerError::Ended(_)), "{flood}");
        let none = LinePeer::start(&["/nowhere/program".to_owned()]).err().unwrap();
        assert!(none.to_string().starts_with("/nowhere/program"), "{none}");
    }
}
