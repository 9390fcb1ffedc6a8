//! A folder with files in it, the program run there, and imitations that it talks to.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

pub(crate) const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const PROGRAM: &str = env!("CARGO_BIN_EXE_spinebench");
/// Whatever is waited for comes within this time, or the test has failed.
const PATIENCE: Duration = Duration::from_secs(240);

/// A folder, and the state folder of the programs that run in it.
pub(crate) struct Bench(tempfile::TempDir);

/// How a program ended, and what it said.
pub(crate) struct Ended {
    pub(crate) status: Option<i32>,
    pub(crate) said: String,
}

impl Ended {
    fn of(output: &Output) -> Ended {
        let said =
            String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
        Ended { status: output.status.code(), said: said.into_owned() }
    }

    /// Demands this exit status and all of these words.
    pub(crate) fn is(&self, status: i32, words: &[&str]) {
        assert_eq!(self.status, Some(status), "{}", self.said);
        for words in words {
            assert!(self.said.contains(words), "no `{words}` in: {}", self.said);
        }
    }
}

impl Bench {
    pub(crate) fn new() -> Bench {
        Bench(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub(crate) fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// A robot on a bench that is imitated. Waiting times are those of a busy computer: none of
    /// this is about them.
    pub(crate) fn put_rehearsal(&self, name: &str, rehearsal: &str) {
        let text = format!(
            "hardware:
  name: robot
  model: {ROOT}/models/nominal.yaml
  settle_s: 0.4
  motion: {{late_s: 5, reply_timeout_s: 10}}
  tracking: {{connect_s: 20}}
  safety: {{tracking_hold_s: 5, hold_stop_s: 10, max_late_ticks: 50}}
  rehearsal: {{model: {ROOT}/models/nominal.yaml, {rehearsal}}}
"
        );
        self.put(name, &text);
    }

    /// `trials` trials of `rows` rows at 5 Hz: a circle of the actuation plane.
    pub(crate) fn put_commands(&self, name: &str, trials: usize, rows: usize) {
        let mut text = String::from("trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m\n");
        for trial in 0..trials {
            for row in 0..rows {
                let angle = 0.15 * row as f64;
                let (x, y) = (0.008 * angle.sin(), 0.008 * (1.0 - angle.cos()));
                let time_s = 0.2 * row as f64;
                text.push_str(&format!("{trial},{time_s:.1},{x:.6},{y:.6},{:.6},{:.6}\n", -x, -y));
            }
        }
        self.put(name, &text);
    }

    pub(crate) fn command(&self, program: &Path, arguments: &str) -> Command {
        let mut command = Command::new(program);
        command.args(arguments.split(' ')).current_dir(self.0.path());
        command.env("XDG_STATE_HOME", self.0.path()).stdin(Stdio::null());
        command
    }

    /// Runs the program to its end.
    pub(crate) fn run(&self, arguments: &str) -> Ended {
        Ended::of(&self.command(Path::new(PROGRAM), arguments).output().unwrap())
    }

    /// Starts the program.
    pub(crate) fn start(&self, arguments: &str) -> Started {
        Started::of(self.command(Path::new(PROGRAM), arguments))
    }

    /// Starts the program with somebody at its standard input.
    pub(crate) fn start_with_hands(&self, arguments: &str) -> Started {
        let mut command = self.command(Path::new(PROGRAM), arguments);
        command.stdin(Stdio::piped());
        Started::of(command)
    }

    /// Starts one of this file's tests that need a robot, in a process of its own.
    pub(crate) fn start_test(&self, name: &str, plant: &str) -> Started {
        let own = std::env::current_exe().unwrap();
        let mut command = self.command(&own, &format!("--ignored --exact --nocapture {name}"));
        // Printing where a panic came from takes longer than the moves that it is to interrupt.
        command.env(PLANT, self.path(plant)).env("RUST_BACKTRACE", "0");
        Started::of(command)
    }

    /// Whether a stop is remembered.
    pub(crate) fn is_latched(&self) -> bool {
        self.path("spinebench/robot.stopped").exists()
    }

    /// Whether the position is known to be in doubt.
    pub(crate) fn is_distrusted(&self) -> bool {
        self.path("spinebench/robot.rehome").exists()
    }

    /// Serves the imitations of `plant`; other programs use them by `served`.
    pub(crate) fn serve(&self, plant: &str, served: &str) -> ServedSimulator<'_> {
        let log = format!("{served}.log.csv");
        let arguments = format!("rehearse --plant {plant} --out {served} --log-file {log}");
        let mut command = self.command(Path::new(PROGRAM), &arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::null());
        let process = command.spawn().unwrap();
        let served_file = self.path(served);
        let served = ServedSimulator { bench: self, process, log };
        until(|| served_file.exists().then_some(()));
        served
    }
}

/// Names the plant for a test that needs a robot.
pub(crate) const PLANT: &str = "SPINEBENCH_TEST_PLANT";

/// Waits for `ready`.
pub(crate) fn until<T>(mut ready: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = ready() {
            return found;
        }
        assert!(begun.elapsed() < PATIENCE, "what is waited for does not come");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// A program that runs.
pub(crate) struct Started(Child);

impl Started {
    fn of(mut command: Command) -> Started {
        Started(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
    }

    /// Sends a signal by its name.
    pub(crate) fn signal(&self, name: &str) {
        let status = Command::new("kill")
            .args([&format!("-{name}"), &self.0.id().to_string()])
            .status()
            .unwrap();
        assert!(status.success());
    }

    pub(crate) fn press_enter(&mut self) {
        writeln!(self.0.stdin.as_mut().unwrap()).unwrap();
    }

    pub(crate) fn end(self) -> Ended {
        Ended::of(&self.0.wait_with_output().unwrap())
    }
}

/// One line of the log of the imitations.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) what: String,
    pub(crate) screws_mm: [f64; 4],
}

/// Imitations in a process of their own, until they are dropped.
pub(crate) struct ServedSimulator<'a> {
    bench: &'a Bench,
    process: Child,
    log: String,
}

impl ServedSimulator<'_> {
    /// Lets something happen, and waits until it has.
    pub(crate) fn wish(&mut self, what: &str) {
        let done = format!("done {what}");
        let count = |log: &[Entry]| log.iter().filter(|entry| entry.what == done).count();
        let before = count(&self.log());
        writeln!(self.process.stdin.as_mut().unwrap(), "{what}").unwrap();
        until(|| (count(&self.log()) > before).then_some(()));
    }

    /// All lines that are whole.
    pub(crate) fn log(&self) -> Vec<Entry> {
        let text = self.bench.text(&self.log);
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole.lines().skip(1).map(entry).collect()
    }

    /// Number of times that homing was asked for.
    pub(crate) fn homings(&self) -> usize {
        self.log().iter().filter(|entry| entry.what == "heard $H").count()
    }

    /// Number of moves heard so far.
    pub(crate) fn moves(&self) -> usize {
        self.log().iter().filter(|entry| target_mm(&entry.what).is_some()).count()
    }

    /// Waits until the screws stand and have stood for a while; the log.
    pub(crate) fn stands(&self) -> Vec<Entry> {
        let state = |log: &[Entry]| {
            log.iter()
                .rev()
                .find(|entry| ["moves", "stands"].contains(&entry.what.as_str()))
                .cloned()
        };
        until(|| {
            let before = self.log();
            std::thread::sleep(Duration::from_millis(600));
            let after = self.log();
            let stands = state(&after).is_some_and(|entry| entry.what == "stands");
            (stands && after.len() == before.len()).then_some(after)
        })
    }
}

impl Drop for ServedSimulator<'_> {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn entry(line: &str) -> Entry {
    let cells: Vec<&str> = line.split(',').collect();
    assert_eq!(cells.len(), 6, "{line}");
    Entry { what: cells[1].to_owned(), screws_mm: [2, 3, 4, 5].map(|k| cells[k].parse().unwrap()) }
}

/// Where a move that was heard goes, mm.
pub(crate) fn target_mm(what: &str) -> Option<[f64; 4]> {
    let words = what.strip_prefix("heard G1 ")?;
    let values: Vec<f64> =
        words.split(' ').take(4).map(|word| word[1..].parse().unwrap()).collect();
    Some([values[0], values[1], values[2], values[3]])
}
