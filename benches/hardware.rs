//! Timing of the control loop by the wall clock: the drivers over a pseudo-terminal and UDP against
//! simulators in another process, with idle processors and with a busy thread on each.
//!
//! `cargo bench --bench hardware` prints a table and writes `results/hardware/timing.csv`.
#![allow(missing_docs)]

use std::hint::black_box;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use spinebench::base::{Plant, Seed};
use spinebench::plants::Hardware;
use spinebench::plants::hardware::Lateness;
use spinebench::specs::{PlantSpec, read_plant};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const STEP_S: f64 = 0.2;
/// Ticks of each row.
const TICKS: usize = 600;
/// Longest start-up time of the simulators.
const PATIENCE: Duration = Duration::from_secs(60);
/// Environment variable with the load, for a second process of this program, whose robot has a
/// state folder of its own.
const LOAD: &str = "SPINEBENCH_BENCH_LOAD";

fn main() {
    if let Ok(load) = std::env::var(LOAD) {
        return measure(&load);
    }
    let mut table = String::from("load,quantity,ticks,p50_ms,p99_ms,most_ms,processors\n");
    for load in ["quiet", "loaded"] {
        let folder = std::env::temp_dir().join(format!("spinebench-timing-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let own = std::env::current_exe().unwrap();
        let output = Command::new(own)
            .current_dir(&folder)
            .env(LOAD, load)
            .env("XDG_STATE_HOME", &folder)
            .stderr(Stdio::inherit())
            .output()
            .unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(output.status.success(), "the row `{load}` failed");
        table.push_str(&String::from_utf8(output.stdout).unwrap());
    }
    print!("{}", table.replace(',', "\t"));
    let file = Path::new(ROOT).join("results/hardware/timing.csv");
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    std::fs::write(file, table).unwrap();
}

/// One row a quantity, on standard output.
fn measure(load: &str) {
    let mut simulator = serve();
    let over = AtomicBool::new(false);
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let busy = if load == "loaded" { processors } else { 0 };
    std::thread::scope(|threads| {
        for _ in 0..busy {
            threads.spawn(|| spin(&over));
        }
        play(load, processors);
        over.store(true, Ordering::SeqCst);
    });
    simulator.kill().unwrap();
    simulator.wait().unwrap();
}

fn spin(over: &AtomicBool) {
    let mut value = 1.0_f64;
    while !over.load(Ordering::Relaxed) {
        value = black_box(value.sin() + 1.0);
    }
}

/// Simulators in another process, as `spinebench rehearse` serves them.
fn serve() -> Child {
    let plant = format!(
        "hardware:
  name: timing
  model: {ROOT}/models/nominal.yaml
  settle_s: 1.0
  motion: {{late_s: 2, reply_timeout_s: 5}}
  safety: {{tracking_hold_s: 1, hold_stop_s: 5, max_late_ticks: 5}}
  rehearsal: {{model: {ROOT}/models/real.yaml, noise_m: 0.0005, loss: 0.01}}
"
    );
    std::fs::write("plant.yaml", plant).unwrap();
    let simulator = Command::new(env!("CARGO_BIN_EXE_spinebench"))
        .args(["rehearse", "--plant", "plant.yaml", "--out", "served.yaml", "--real-time"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !Path::new("served.yaml").exists() {
        assert!(begun.elapsed() < PATIENCE, "the simulators do not start");
        std::thread::sleep(Duration::from_millis(20));
    }
    simulator
}

fn play(load: &str, processors: usize) {
    let PlantSpec::Hardware(options) = read_plant(Path::new("served.yaml")).unwrap() else {
        panic!("no robot")
    };
    let mut robot = Hardware::open(&options, STEP_S, Seed(1)).unwrap();
    robot.reset(Seed(1)).unwrap();
    robot.reset_timing();
    for k in 1..=TICKS {
        let angle = 0.08 * k as f64;
        let (x, y) = (0.012 * angle.sin(), 0.012 * (1.0 - angle.cos()));
        robot.step(&[x, y, -x, -y]).unwrap();
    }
    let timing = robot.timing();
    for (name, times) in
        [("command to wire", &timing.latency), ("lateness of the tick", &timing.jitter)]
    {
        row(load, name, times, processors);
    }
    eprintln!("{load}: {} ticks missed, {} held", timing.missed, timing.held);
}

fn row(load: &str, name: &str, times: &Lateness, processors: usize) {
    let ms = |share: f64| 1e3 * times.quantile_s(share);
    let (count, most_ms) = (times.count(), 1e3 * times.most_s());
    println!("{load},{name},{count},{:.3},{:.3},{most_ms:.3},{processors}", ms(0.5), ms(0.99));
}
