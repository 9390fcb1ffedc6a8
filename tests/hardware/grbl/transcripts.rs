//! Dialogues with the simulator of a real grblHAL.

use std::path::{Path, PathBuf};

use spinebench::hardware::grbl::parser::{Reply, parse};
use spinebench::hardware::grbl::{Mode, codes};
use spinebench::hardware::serial::SerialLine;
use spinebench::simulators::{
    ControllerFault, ControllerOptions, PipeEnd, SimulatedController, factory_settings, pipe,
    robot_settings,
};

/// Folder of the transcripts: they come with the tests.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/grbl")
}

/// A line of a transcript.
#[derive(Clone, Debug)]
struct Entry {
    time_s: f64,
    sent: bool,
    text: String,
}

fn entries(text: &str) -> Vec<Entry> {
    let entry = |line: &str| {
        let (time, rest) = line.trim_start().split_once(' ')?;
        let time_s = time.parse().ok()?;
        let sent = rest.starts_with("> ");
        (sent || rest.starts_with("< ")).then(|| Entry { time_s, sent, text: rest[2..].to_owned() })
    };
    text.lines().filter_map(entry).collect()
}

/// What a reply amounts to; nothing for messages, settings and other texts.
fn kind(line: &str) -> Option<String> {
    match parse(line)? {
        Reply::Ok => Some("ok".to_owned()),
        Reply::Error(code) => Some(format!("error {code}")),
        Reply::Alarm(code) => Some(format!("alarm {code}")),
        Reply::Boot(_) => Some("boot".to_owned()),
        Reply::Status(status) => Some(status.mode.to_string()),
        _ => None,
    }
}

#[test]
fn every_received_line_is_understood() {
    let folder = folder();
    let mut count = 0;
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "txt") {
            continue;
        }
        for entry in
            entries(&std::fs::read_to_string(&path).unwrap()).iter().filter(|entry| !entry.sent)
        {
            let reply =
                parse(&entry.text).unwrap_or_else(|| panic!("{}: {}", path.display(), entry.text));
            match reply {
                Reply::Error(code) => assert!(codes::knows_error(code), "{code}"),
                Reply::Alarm(code) => assert!(codes::knows_alarm(code), "{code}"),
                Reply::Status(status) => {
                    assert!(status.position_mm.is_some() && status.mode != Mode::Unknown)
                }
                _ => {}
            }
            count += 1;
        }
    }
    assert!(count > 800, "{count}");
}

/// The bytes behind what a transcript calls them.
fn bytes(text: &str) -> Vec<u8> {
    match text.trim_end_matches(" in Run").trim_matches('\'') {
        "ctrl-X" | "0x18" => vec![0x18],
        "ctrl-Y" | "0x19" => vec![0x19],
        "0x82" => vec![0x82],
        "0x85" => vec![0x85],
        "\\n" => b"\n".to_vec(),
        short @ ("?" | "!" | "~") => short.as_bytes().to_vec(),
        line => match line.strip_suffix("\\r\\n") {
            Some(line) => format!("{line}\r\n").into_bytes(),
            None => format!("{line}\n").into_bytes(),
        },
    }
}

struct Replay {
    fake: SimulatedController,
    serial: PipeEnd,
    now_s: f64,
    received: Vec<u8>,
}

impl Replay {
    fn until(&mut self, time_s: f64) {
        while self.now_s < time_s {
            self.now_s = (self.now_s + 0.002).min(time_s);
            self.fake.step(self.now_s);
            let mut buffer = [0; 4096];
            let count = self.serial.read(&mut buffer).unwrap();
            self.received.extend(&buffer[..count]);
        }
    }
}

/// What the fake controller answers to the sent lines of a transcript, sent at the same times.
fn replay(entries: &[Entry], options: ControllerOptions, fault: Option<ControllerFault>) -> String {
    let (serial, other) = pipe();
    // A little quicker than the simulator, so that everything is answered before the next line.
    let options = ControllerOptions { delay_s: [0.002, 0.01], ..options };
    let mut replay = Replay {
        fake: SimulatedController::new(Box::new(other), options),
        serial,
        now_s: 0.9,
        received: Vec::new(),
    };
    replay.fake.step(replay.now_s);
    fault.into_iter().for_each(|fault| replay.fake.inject(fault));
    for entry in entries.iter().filter(|entry| entry.sent) {
        replay.until(entry.time_s);
        replay.serial.write(&bytes(&entry.text)).unwrap();
    }
    let last_s = entries.last().map_or(0.0, |entry| entry.time_s);
    replay.until(last_s + 0.02);
    String::from_utf8(replay.received).unwrap()
}

/// Replays a transcript; `same` turns the kinds of the simulator into those that are expected.
fn compare(
    name: &str,
    options: ControllerOptions,
    fault: Option<ControllerFault>,
    same: impl Fn(&mut Vec<String>),
) {
    let folder = folder();
    let entries = entries(&std::fs::read_to_string(folder.join(name)).unwrap());
    let mut theirs: Vec<String> =
        entries.iter().filter(|entry| !entry.sent).filter_map(|entry| kind(&entry.text)).collect();
    same(&mut theirs);
    let ours: Vec<String> = replay(&entries, options, fault).lines().filter_map(kind).collect();
    let differs = theirs.iter().zip(&ours).position(|(theirs, ours)| theirs != ours);
    let place = differs.unwrap_or(theirs.len().min(ours.len()));
    assert!(
        theirs == ours,
        "{name}: reply {place}: {:?} and then {:?}, expected {:?}",
        &ours[..place],
        &ours[place..],
        &theirs[place..]
    );
}

/// The robot's settings as far as the simulator had them.
fn robot() -> ControllerOptions {
    let mut settings = robot_settings();
    settings.insert(1, "25".to_owned());
    ControllerOptions { settings, ..ControllerOptions::default() }
}

fn new() -> ControllerOptions {
    ControllerOptions {
        settings: factory_settings(),
        first_boot: true,
        ..ControllerOptions::default()
    }
}

fn as_it_is(_: &mut Vec<String>) {}

fn place(kinds: &[String], wanted: &str, from: usize) -> usize {
    from + kinds[from..].iter().position(|kind| kind == wanted).unwrap()
}

#[test]
fn the_fake_controller_answers_as_the_real_one() {
    for name in [
        "abort_then_unhomed_soft_limit",
        "g1_jogcancel_ignored",
        "homing_repeat",
        "homing_switch_closed_at_start",
        "jog_stop_0x18",
        "jog_stop_0x82",
        "jog_stop_0x85",
        "jog_stop_excl",
        "reset_during_homing",
        "stream_5hz_g1",
    ] {
        compare(&format!("transcript_{name}.txt"), robot(), None, as_it_is);
    }
    compare("transcript_unmodified_sim.txt", new(), None, as_it_is);
}

#[test]
fn a_machine_is_set_up_homed_moved_and_unlocked() {
    compare("transcript_4axis_switches.txt", new(), None, |theirs| {
        // Here the simulator swallowed the alarm of a reset during a move; in the others it did
        // not.
        let jogged = place(theirs, "error 15", 0);
        let boot = place(theirs, "boot", jogged);
        theirs.insert(boot, "alarm 3".to_owned());
    });
}

#[test]
fn errors_repeat_and_carriage_returns_are_lines() {
    compare("transcript_error_codes.txt", robot(), None, |theirs| {
        // An empty line that met the alarm was dropped.
        let alarm = place(theirs, "alarm 2", 0);
        theirs.insert(alarm + 1, "ok".to_owned());
    });
}

#[test]
fn a_reset_after_a_hold_keeps_the_position() {
    compare("transcript_g1_hold_then_reset.txt", robot(), None, as_it_is);
}

#[test]
fn limits_and_failed_homing() {
    // The last answers had not come when the transcripts ended.
    compare("transcript_hard_limit.txt", robot(), None, |theirs| theirs.push("ok".to_owned()));
    compare("transcript_abort_cycle_alarm3.txt", robot(), None, |theirs| {
        theirs.push("Run".to_owned())
    });
    compare(
        "transcript_homing_switch_stuck_open.txt",
        robot(),
        Some(ControllerFault::SwitchStuckOpen(3)),
        as_it_is,
    );
    compare("transcript_poll_during_homing.txt", robot(), None, |theirs| {
        // The first query was quicker than homing.
        let home = place(theirs, "Home", 0);
        theirs.remove(home);
    });
}

#[test]
fn the_fake_controller_moves_as_fast_as_the_real_one() {
    let folder = folder();
    let text = std::fs::read_to_string(folder.join("transcript_stream_5hz_g1.txt")).unwrap();
    let entries = entries(&text);
    let position = |line: &str| match parse(line)? {
        Reply::Status(status) => status.position_mm,
        _ => None,
    };
    let theirs: Vec<_> = entries
        .iter()
        .filter(|entry| !entry.sent)
        .filter_map(|entry| position(&entry.text))
        .collect();
    let ours: Vec<_> = replay(&entries, robot(), None).lines().filter_map(position).collect();
    assert_eq!(theirs.len(), ours.len());
    // The simulator answers up to 0.1 s later, at 10 mm/s.
    let off_mm = |axis: usize| {
        let off = theirs.iter().zip(&ours).map(|(theirs, ours)| (theirs[axis] - ours[axis]).abs());
        off.fold(0.0, f64::max)
    };
    let off_mm = [0, 1, 2, 3].map(off_mm);
    assert!(off_mm.iter().all(|&off_mm| off_mm < 1.0), "{off_mm:?}");
}
