//! The synthetic tracker against a client that is not ours: PyPI's `natnet` 0.3.0, in Python, from
//! its own reading of the protocol. The package has no server; that our client reads a real one is
//! tested on recordings of Motive.
//!
//! Without Python or the package the test is skipped, and says so, unless
//! `SPINEBENCH_PEERS=required` as in `.ci/run`.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use natnet::Version;
use spinebench::hardware::clock::{Clock, WallClock};
use spinebench::hardware::tracking::{RigidPose, Transport};
use spinebench::simulators::{SimulatedTracker, TrackerOptions};

const PACKAGE: &str = "natnet==0.3.0";

/// Frames that the peer waits for.
const FRAMES: usize = 25;

/// The peer is ended after so long, s.
const LONGEST_S: f64 = 120.0;

/// Prints the server, the bodies, and of each frame its number, stamp and bodies, one value after
/// the other.
const CLIENT: &str = r#"
import sys, time
from natnet import NatNetClient
port, data_port, multicast, count = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3] == "multicast", int(sys.argv[4])
frames, described = [], []
client = NatNetClient("127.0.0.1", "127.0.0.1", command_port=port, data_port=data_port, use_multicast=multicast)
client.on_data_frame_received_event.handlers.append(frames.append)
client.on_data_description_received_event.handlers.append(described.append)
with client:
    print("version", client.protocol_version.major, client.protocol_version.minor)
    end = time.time() + 60
    while time.time() < end and (len(frames) < count or not described):
        if not described:
            client.request_modeldef()
        client.update_sync()
        time.sleep(0.01)
    for body in described[0].rigid_bodies:
        print("body", body.id_num, body.name)
    for frame in frames[:count]:
        for body in frame.rigid_bodies:
            values = [body.id_num, *body.pos, *body.rot, int(body.tracking_valid)]
            print("frame", frame.prefix.frame_number, repr(frame.suffix.timestamp), *map(repr, values))
"#;

/// A Python with the package, in the build folder; made once.
fn python() -> Result<PathBuf, String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("natnet-peer");
    let python = folder.join("bin/python");
    let imports =
        |python: &Path| run(Command::new(python).args(["-c", "import natnet.nat_net_client"]));
    if imports(&python).is_err() {
        run(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
        run(Command::new(&python).args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--no-deps",
            "--timeout",
            "20",
            PACKAGE,
        ]))?;
        imports(&python)?;
    }
    Ok(python)
}

fn run(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(()) } else { Err(format!("{command:?}: {told}")) }
}

/// Where base and tip are at `time_s`; numbers that single precision holds exactly.
fn bodies(time_s: f64) -> (RigidPose, RigidPose) {
    let base = RigidPose { position_m: [1.5, 0.25, -2.0], quaternion: [0.5, 0.5, -0.5, 0.5] };
    (base, RigidPose::at([0.125 * time_s, -0.75, 0.5 + time_s]))
}

/// Serves the peer until it ends; what it printed.
fn serve(tracker: &mut SimulatedTracker, mut peer: Child) -> String {
    // By the wall clock, for the peer's sake; nothing is measured by it.
    let clock = WallClock::new();
    let mut time_s = 0.0;
    while time_s < LONGEST_S && peer.try_wait().unwrap().is_none() {
        let (base, tip) = bodies(time_s);
        tracker.step(time_s, &tip, &base);
        std::thread::sleep(Duration::from_millis(1));
        time_s = clock.now_s();
    }
    let _ = peer.kill();
    let status = peer.wait().unwrap();
    let (mut printed, mut errors) = (String::new(), String::new());
    peer.stdout.unwrap().read_to_string(&mut printed).unwrap();
    peer.stderr.unwrap().read_to_string(&mut errors).unwrap();
    assert!(status.success(), "{printed}\n{errors}");
    assert!(!printed.contains("Warning"), "{printed}");
    printed
}

fn agrees(python: &Path, version: Version, transport: Transport) {
    let offset_s = 64.0;
    let options =
        TrackerOptions { version, transport, clock_offset_s: offset_s, ..Default::default() };
    let mut tracker = SimulatedTracker::new(options).unwrap();
    let settings = tracker.settings().unwrap();
    let peer = Command::new(python)
        .args([
            "-u",
            "-c",
            CLIENT,
            &settings.command_port.to_string(),
            &settings.data_port.to_string(),
        ])
        .args([
            if transport == Transport::Multicast { "multicast" } else { "unicast" },
            &FRAMES.to_string(),
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let printed = serve(&mut tracker, peer);
    let lines: Vec<Vec<&str>> = printed.lines().map(|line| line.split(' ').collect()).collect();
    let of = |kind: &str| {
        lines
            .iter()
            .filter(|line| line[0] == kind)
            .map(|line| line[1..].to_vec())
            .collect::<Vec<_>>()
    };
    assert_eq!(of("version"), [[version.major.to_string(), version.minor.to_string()]]);
    assert_eq!(of("body"), [["1", "base"], ["2", "tip"], ["7", "table"]]);
    let frames = of("frame");
    assert_eq!(frames.len(), 3 * FRAMES, "{version} {transport:?}");
    let mut last = 0;
    for line in frames {
        let number: u32 = line[0].parse().unwrap();
        let values: Vec<f64> = line[1..].iter().map(|text| text.parse().unwrap()).collect();
        assert!(number >= last && values[9] == 1.0);
        last = number;
        // Frame numbers count periods of the tracker's time.
        let time_s = f64::from(number - 100_000) * 0.01;
        assert!((values[0] - offset_s - time_s).abs() < 1e-9);
        let (base, tip) = bodies(time_s);
        let expected = match values[1] as i32 {
            1 => base,
            2 => tip,
            _ => RigidPose::default(),
        };
        let [w, x, y, z] = expected.quaternion;
        let expected = [&expected.position_m[..], &[x, y, z, w]].concat();
        for (seen, expected) in values[2..9].iter().zip(expected) {
            assert!((seen - expected).abs() <= 1e-6 * (1.0 + expected.abs()), "{seen} {expected}");
        }
    }
}

#[test]
fn a_python_client_sees_what_the_tracker_shows() {
    let python = match python() {
        Ok(python) => python,
        Err(why) if std::env::var("SPINEBENCH_PEERS").is_ok_and(|value| value == "required") => {
            panic!("{why}")
        }
        Err(why) => {
            // Past the harness, which shows nothing of tests that pass.
            let _ = writeln!(
                std::io::stderr(),
                "skipped: a_python_client_sees_what_the_tracker_shows: {why}"
            );
            return;
        }
    };
    for version in SimulatedTracker::VERSIONS {
        agrees(&python, version, Transport::Unicast);
    }
    agrees(&python, Version::V4_1, Transport::Multicast);
}
