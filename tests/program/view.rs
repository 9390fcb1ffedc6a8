//! `view` through the program itself: scenes as the solver computes them, who is served, what the
//! live view answers, and the GIF.

use serde_json::{Value, json};
use spinebench::data::Recording;
use spinebench::data::scene::{Scene, SceneObstacle};
use spinebench::effects::Model;
use spinebench::specs::read_model;
use spinebench::tasks::{SimulationOptions, scene_of_recording, scene_robot, simulate_recording};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const PROGRAM: &str = env!("CARGO_BIN_EXE_spinebench");

fn model(name: &str) -> Model {
    read_model(&Path::new(ROOT).join("models").join(name)).unwrap()
}

fn recording() -> Recording {
    Recording::read(&*Path::new(ROOT).join("tests/data/twin/r12.csv")).unwrap()
}

/// A scene of the first trial of the shipped recording.
fn scene(model: &Model) -> (Scene, Recording) {
    let recording = recording();
    let rows: Vec<usize> = recording.trials()[0].1.clone().collect();
    let trial = recording.rows(&rows);
    (scene_of_recording("r12", Path::new("r12.csv"), &trial, model, false).unwrap(), trial)
}

#[test]
fn the_tip_of_a_scene_is_that_of_a_simulation() {
    let model = model("nominal.yaml");
    let (scene, trial) = scene(&model);
    let simulated = simulate_recording(&model, &trial, &SimulationOptions::default());
    assert_eq!(scene.frames.len(), trial.len());
    for (row, frame) in scene.frames.iter().enumerate() {
        let expected = simulated.tip_m.as_ref().unwrap()[row];
        let (tip, last) = (frame.tip_m.unwrap(), frame.poses.last().unwrap().position_m());
        for axis in 0..3 {
            assert!((tip[axis] - expected[axis]).abs() <= 1e-12, "row {row}");
            assert!((last[axis] - expected[axis]).abs() <= 1e-9, "row {row}");
        }
        assert_eq!(frame.time_s, trial.time_s[row]);
        assert_eq!(frame.measured_m.len(), 1);
        assert_eq!(frame.poses.len(), scene.robot.stations.len());
    }
    let slack = scene.frames.iter().any(|frame| frame.tensions_n.contains(&0.0));
    assert!(slack, "a tendon of this recording goes slack");
    // A page carries it rounded.
    let scene = scene.rounded();
    let json = serde_json::to_string(&scene).unwrap();
    assert!(serde_json::from_str::<Scene>(&json).unwrap() == scene, "{json:.200}");
    assert!(json.len() < 600 * scene.frames.len() + 4000, "{} bytes", json.len());
}

#[test]
fn robots_are_drawn_as_their_models_say() {
    for name in
        ["nominal.yaml", "tdcr_two_segments.yaml", "tentacle.yaml", "trunk.yaml", "till.yaml"]
    {
        let model = model(name);
        let (robot, rod) = (scene_robot(&model), model.rod(&[]));
        let places: Vec<f64> = robot.stations.iter().map(|station| station.s_m).collect();
        assert!(places.windows(2).all(|pair| pair[0] < pair[1]), "{name}: {places:?}");
        assert_eq!((places[0], *places.last().unwrap()), (0.0, rod.length_m()), "{name}");
        assert_eq!(robot.tendons.len(), rod.tendons.len(), "{name}");
        for (drawn, tendon) in robot.tendons.iter().zip(&rod.tendons) {
            let last = drawn.first + drawn.holes_m.len() - 1;
            assert!((places[drawn.first] - tendon.start_m).abs() < 1e-6, "{name}");
            assert!((places[last] - tendon.end_m).abs() < 1e-6, "{name}");
            let [x, y] = tendon.path.at(tendon.end_m).0;
            let hole = drawn.holes_m.last().unwrap();
            assert!((hole[0] - x).hypot(hole[1] - y) < 1e-5, "{name}");
        }
        let disks = robot.stations.iter().filter(|station| station.disk_radius_m > 0.0).count();
        assert_eq!(disks, model.robot.disks.count.min(200), "{name}");
    }
    let text = "robot: {backbone: {length_m: 0.3, radius_m: 0.003, youngs_modulus_pa: 2.5e9, \
                poisson_ratio: 0.39}, tendons: {radius_m: 0.02, angles_deg: [0, 120, 240]}}\n\
                obstacles:\n- sphere: {center_m: [0.1, 0.0, 0.2], radius_m: 0.03}\n\
                - plane: {normal: [2.0, 0.0, 0.0], distance_m: -0.2}\n";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("model.yaml");
    std::fs::write(&file, text).unwrap();
    let robot = scene_robot(&read_model(&file).unwrap());
    assert_eq!(
        robot.obstacles,
        [
            SceneObstacle::Sphere { center_m: [0.1, 0.0, 0.2], radius_m: 0.03 },
            SceneObstacle::HalfSpace { normal: [1.0, 0.0, 0.0], offset_m: -0.2 },
        ]
    );
}

/// The program as it serves a page.
struct Served {
    child: Child,
    /// Host and port.
    host: String,
    /// Path of the page.
    path: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Served {
    fn start(arguments: &[&str]) -> Served {
        let mut child = Command::new(PROGRAM)
            .args(["view", "--no-open"])
            .args(arguments)
            .current_dir(ROOT)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let rest = line.trim().strip_prefix("http://").expect(&line).to_owned();
        let (host, path) = rest.split_once('/').unwrap();
        Served { child, host: host.to_owned(), path: format!("/{path}") }
    }

    /// The answer to a request of this host for this path.
    fn get(&self, path: &str, host: &str) -> String {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    /// A socket that says it is of a page from `origin`.
    fn socket(&self, origin: Option<&str>) -> Result<WebSocket<TcpStream>, String> {
        let address = format!("ws://{}{}socket", self.host, self.path);
        let mut request = address.into_client_request().unwrap();
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().unwrap());
        }
        let stream = TcpStream::connect(&self.host).unwrap();
        tungstenite::client(request, stream)
            .map(|(socket, _)| socket)
            .map_err(|error| error.to_string())
    }

    fn own_socket(&self) -> WebSocket<TcpStream> {
        self.socket(Some(&format!("http://{}", self.host))).unwrap()
    }
}

/// The next answer in which `wanted` holds.
fn answer(socket: &mut WebSocket<TcpStream>, wanted: impl Fn(&Value) -> bool) -> Value {
    for _ in 0..600 {
        if let Message::Text(text) = socket.read().unwrap() {
            let answer: Value = serde_json::from_str(&text).unwrap();
            if wanted(&answer) {
                return answer;
            }
        }
    }
    panic!("no such answer");
}

fn ask(socket: &mut WebSocket<TcpStream>, state: &Value) {
    socket.send(Message::text(state.to_string())).unwrap();
}

#[test]
fn only_who_knows_the_token_is_served() {
    let served = Served::start(&["models/nominal.yaml"]);
    assert!(served.get(&served.path, &served.host).starts_with("HTTP/1.1 200 "));
    for (path, host) in [
        ("/", served.host.as_str()),
        ("/00000000000000000000000000000000/", &served.host),
        (served.path.trim_end_matches('/'), &served.host),
    ] {
        assert!(served.get(path, host).starts_with("HTTP/1.1 404 "), "{path}");
    }
    // A name that another computer could give to this one.
    assert!(served.get(&served.path, "robot.example").starts_with("HTTP/1.1 403 "));
    assert!(served.socket(None).is_err());
    assert!(served.socket(Some("http://robot.example")).is_err());
    assert!(served.socket(Some(&format!("http://{}", served.host))).is_ok());
}

#[test]
fn the_live_robot_answers_as_simulate_says() {
    let served = Served::start(&["models/nominal.yaml"]);
    let mut socket = served.own_socket();
    let state = |effects: Value, at_rest: bool| json!({"displacements": [0.006, 0.002, -0.005, -0.002], "at_rest": at_rest, "effects": effects});
    let tip = |answer: &Value| -> [f64; 3] {
        serde_json::from_value(answer["frame"]["tip_m"].clone()).unwrap()
    };
    let expected = |extra: &str| -> [f64; 3] {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let nominal = std::fs::read_to_string(Path::new(ROOT).join("models/nominal.yaml")).unwrap();
        let nominal =
            if extra.is_empty() { nominal } else { nominal.replace("effects: []", extra) };
        std::fs::write(path("model.yaml"), nominal).unwrap();
        let commands = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m\n0,0,0.006,0.002,-0.005,-0.002\n";
        std::fs::write(path("commands.csv"), commands).unwrap();
        let output = Command::new(PROGRAM)
            .args([
                "simulate",
                "--static",
                "--model",
                "model.yaml",
                "--commands",
                "commands.csv",
                "--out",
                "out.csv",
            ])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        Recording::read_poses(&*path("out.csv")).unwrap().tip_m.unwrap()[0]
    };
    let near = |one: [f64; 3], other: [f64; 3], within_m: f64| {
        assert!(spinebench::base::distance_m(&one, &other) < within_m, "{one:?} {other:?}");
    };
    ask(&mut socket, &state(json!([]), true));
    let first = answer(&mut socket, |answer| !answer["frame"].is_null());
    assert_eq!(first["status"], "converged");
    near(tip(&first), expected(""), 1e-5);
    // The motion comes to rest there.
    ask(&mut socket, &state(json!([]), false));
    let later = answer(&mut socket, |answer| answer["frame"]["time_s"].as_f64() > Some(1.5));
    near(tip(&later), expected(""), 2e-4);
    let load = json!([{"name": "tip_load", "values": [0.02]}]);
    ask(&mut socket, &state(load, true));
    let loaded = answer(&mut socket, |answer| {
        !answer["frame"].is_null() && answer["frame"]["time_s"].as_f64() < Some(0.2)
    });
    near(tip(&loaded), expected("effects: [{tip_load: {mass_kg: 0.02}}]"), 1e-5);
    assert!(spinebench::base::distance_m(&tip(&loaded), &tip(&first)) > 2e-3);
    // What cannot be is said, and the robot goes on.
    ask(&mut socket, &state(json!([{"name": "tip_load", "values": [-1.0]}]), true));
    let refused = answer(&mut socket, |answer| !answer["error"].is_null());
    assert!(refused["error"].as_str().unwrap().contains("tip_load"), "{refused}");
    ask(&mut socket, &state(json!([]), true));
    let again =
        answer(&mut socket, |answer| !answer["frame"].is_null() && answer["error"].is_null());
    near(tip(&again), tip(&first), 2e-5);
}

/// Four rigid tendons that are pulled alike: one tension more than the shape determines.
#[test]
fn a_common_pull_is_shared_by_all_tendons() {
    let served = Served::start(&["models/nominal.yaml"]);
    let mut socket = served.own_socket();
    let state = |displacements: [f64; 4]| json!({"displacements": displacements, "at_rest": true, "effects": []});
    ask(&mut socket, &state([0.024; 4]));
    let common = answer(&mut socket, |answer| !answer["frame"].is_null());
    let tensions: Vec<f64> = serde_json::from_value(common["frame"]["tensions_n"].clone()).unwrap();
    assert_eq!(common["undetermined"], true);
    assert_eq!(common["slack"], json!([]));
    assert!(tensions.iter().all(|tension| *tension > 2.0), "{tensions:?}");
    let difference = tensions[0] + tensions[2] - tensions[1] - tensions[3];
    assert!(difference.abs() < 0.05, "{tensions:?}");
    ask(&mut socket, &state([0.01, 0.0, -0.01, 0.0]));
    let bent = answer(&mut socket, |answer| !answer["frame"].is_null());
    assert_eq!(bent["undetermined"], false);
    assert!(bent["slack"].as_array().unwrap().contains(&json!(2)), "{bent}");
}

fn view(arguments: &[&str]) -> Output {
    Command::new(PROGRAM).arg("view").args(arguments).current_dir(ROOT).output().unwrap()
}

#[test]
fn a_recording_becomes_a_gif() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("robot.gif");
    let recording = "tests/data/twin/r12.csv";
    let out_text = out.to_str().unwrap();
    let output = view(&[
        "--record",
        out_text,
        recording,
        "--model",
        "models/nominal.yaml",
        "--seconds",
        "1",
    ]);
    assert!(output.status.success(), "{output:?}");
    let bytes = std::fs::read(&out).unwrap();
    assert_eq!(&bytes[..6], b"GIF89a");
    let mut decoder = gif::DecodeOptions::new().read_info(&bytes[..]).unwrap();
    assert_eq!((decoder.width(), decoder.height()), (800, 318));
    let mut frames = 0;
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert!(frame.width > 1, "the robot moves");
        frames += 1;
    }
    assert_eq!(frames, 10);
}

#[test]
fn bad_input_is_one_error() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("robot.gif");
    let out = out.to_str().unwrap();
    for (arguments, words) in [
        (vec!["nothing.yaml", "--no-open"], "nothing.yaml"),
        (vec!["models/nominal.yaml", "--record", out], "found a model"),
        (vec!["models/nominal.yaml", "tests/data/twin/r12.csv"], "expected the model alone"),
        (vec!["tests/data/twin/r12.csv", "--trial", "99", "--no-open"], "--trial: found 99"),
        (vec!["tests/data/twin/r12.csv", "--record", "robot.mp4"], ".mp4"),
        (vec!["results/table1", "--no-open"], "no tracked path"),
        (vec!["results", "--no-open"], "expected the folder of one experiment"),
        (vec!["results/fig8/spec.yaml", "--no-open"], "found an experiment, expected a model"),
    ] {
        let output = view(&arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(words) && said.trim_end().lines().count() == 1, "{said}");
    }
    assert!(!Path::new(out).exists());
}
