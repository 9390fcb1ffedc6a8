//! `spinebench doctor`.

use super::session::read_hardware_plant;
use super::{CommandError, CommandResult};
use clap::Args;
use spinebench::base::{Plant, Seed, distance_m};
use spinebench::hardware::grbl::codes;
use spinebench::plants::hardware::{Diagnostics, Hardware, HardwareOptions};
use std::path::PathBuf;

/// Control step of the check, s.
const STEP_S: f64 = 0.2;
/// Observation time of the tracker, s.
const WATCH_S: f64 = 2.0;
/// Test displacement of each tendon, metres, in steps of a third of it.
const PULL_M: f64 = 0.006;
/// Smallest motion of the tip that counts as motion, metres.
const SEEN_M: f64 = 0.002;

/// Smallest cosine between the measured and the predicted direction of the tip: sag changes it by tens of degrees,
/// swapped tendons by ninety and more.
const ALONG: f64 = 0.5;

/// Check a robot's hardware: ports, versions, settings, rates, frames. Moves nothing without --move.
#[derive(Args)]
pub(super) struct DoctorCommand {
    /// Plant file with `hardware:`.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
    /// Home the axes and pull each tendon by 6 mm, to check that the tip moves as the model predicts.
    #[arg(long = "move")]
    moving: bool,
}

impl DoctorCommand {
    pub(super) fn execute(self) -> CommandResult {
        let options = read_hardware_plant(&self.plant)?;
        let mut plant = Hardware::open(&options, STEP_S, Seed(1)).map_err(CommandError::failed)?;
        let diagnostics = plant.run_diagnostics(WATCH_S);
        let mut wrong = report(&diagnostics, &options);
        if self.moving {
            wrong += test_tendons(&mut plant)?;
        } else {
            println!("       nothing was moved; use --move to home the axes and pull each tendon by 6 mm");
        }
        if wrong > 0 { Err(CommandError::Failed(format!("failed checks: {wrong}"))) } else { Ok(()) }
    }
}

/// Prints one check; returns the number of failed ones.
fn print_check(good: bool, what: &str) -> usize {
    println!("{}  {what}", if good { "ok   " } else { "WRONG" });
    usize::from(!good)
}

/// Names an alarm, its meaning, and what clears it.
fn alarm_text(code: u16) -> String {
    let number = if code == 0 { "of unknown number".to_owned() } else { code.to_string() };
    let clears = if codes::needs_person(code) {
        "no program moves the robot until then"
    } else {
        "the next program that moves the robot (`collect`, `doctor --move`) resets and homes it"
    };
    format!("controller: alarm {number}: {} {clears}", codes::alarm(code))
}

fn report(diagnostics: &Diagnostics, options: &HardwareOptions) -> usize {
    let (rate_hz, near_m) = (options.tracking.rate_hz, options.safety.tip_from_model_m);
    let Diagnostics { controller, alarm, homed, position_mm, server, tracking, tip, home_m, real_time } = diagnostics;
    let mut wrong = print_check(true, &format!("controller: {controller}"));
    if let Some(code) = *alarm {
        wrong += print_check(false, &alarm_text(code));
    }
    let position = position_mm.map(|mm| format!("{mm:.3}")).join(", ");
    wrong +=
        print_check(true, &format!("axes: {}, position {position} mm", if *homed { "homed" } else { "not homed" }));
    wrong += print_check(true, &format!("tracker: {server}"));
    let rate = tracking.rate_hz.unwrap_or(0.0);
    wrong += print_check((rate - rate_hz).abs() < 0.05 * rate_hz, &format!("frames: {rate:.1} Hz, expected {rate_hz}"));
    let lost = tracking.lost as f64 / (tracking.lost + tracking.received).max(1) as f64;
    wrong += print_check(lost < 0.05, &format!("frames lost: {:.1} %, expected below 5", 100.0 * lost));
    let jitter_ms = tracking.latency_jitter_s * 1e3;
    wrong += print_check(jitter_ms < 20.0, &format!("frame jitter: {jitter_ms:.1} ms, expected below 20"));
    wrong +=
        print_check(tracking.foreign == 0, &format!("frames from other servers: {}, expected 0", tracking.foreign));
    wrong += print_check(tracking.malformed == 0, &format!("unreadable frames: {}, expected 0", tracking.malformed));
    match tip {
        None => wrong += print_check(false, "tip: not tracked, expected both bodies in view"),
        Some(tip_m) => {
            let off_m = distance_m(tip_m, home_m);
            let place = tip_m.map(|x| format!("{:.1}", x * 1e3)).join(", ");
            wrong += print_check(
                off_m <= near_m,
                &format!(
                    "tip: ({place}) mm, {:.1} mm from the model's home, expected at most {:.1}",
                    off_m * 1e3,
                    near_m * 1e3
                ),
            );
        }
    }
    if let Some(granted) = real_time {
        let words =
            if *granted { "granted" } else { "not granted: other programs can delay commands; see docs/hardware.md" };
        println!("       real-time priority: {words}");
    }
    wrong
}

/// Homes the robot and pulls each tendon; returns the number of those that do not move as the model predicts.
fn test_tendons(plant: &mut Hardware) -> Result<usize, CommandError> {
    let failed = |error: spinebench::base::PlantError| CommandError::Failed(error.to_string());
    let mut wrong = 0;
    let home_m = plant.reset(Seed(1)).map_err(failed)?.tip_m;
    for tendon in 0..plant.tendons() {
        let mut seen = None;
        for share in [1.0, 2.0, 3.0, 3.0, 3.0, 3.0] {
            let mut pulls_m = vec![0.0; plant.tendons()];
            pulls_m[tendon] = PULL_M * share / 3.0;
            pulls_m[(tendon + 2) % 4] = -PULL_M * share / 3.0;
            seen = Some(plant.step(&pulls_m).map_err(failed)?);
        }
        let expected_m = plant.expected_m();
        let moved = seen.map_or([f64::NAN; 3], |seen| std::array::from_fn(|axis| seen.tip_m[axis] - home_m[axis]));
        let wanted: [f64; 3] = std::array::from_fn(|axis| expected_m[axis] - home_m[axis]);
        let length = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let along: f64 =
            moved.iter().zip(&wanted).map(|(a, b)| a * b).sum::<f64>() / (length(&moved) * length(&wanted));
        let good = length(&moved) > SEEN_M && along > ALONG;
        let words = format!(
            "tendon {}: pulled {:.0} mm, tip moved {:.1} mm, predicted {:.1} mm, {:.0} degrees apart",
            tendon + 1,
            PULL_M * 1e3,
            length(&moved) * 1e3,
            length(&wanted) * 1e3,
            along.clamp(-1.0, 1.0).acos().to_degrees()
        );
        wrong += print_check(good, &words);
        plant.reset(Seed(1)).map_err(failed)?;
    }
    let timing = plant.timing();
    let (latency_ms, jitter_ms) = (1e3 * timing.latency.quantile_s(0.99), 1e3 * timing.jitter.quantile_s(0.99));
    wrong += print_check(latency_ms <= 2.0, &format!("command latency: 99 % within {latency_ms:.2} ms, expected 2"));
    wrong += print_check(jitter_ms <= 5.0, &format!("tick jitter: 99 % within {jitter_ms:.2} ms, expected 5"));
    Ok(wrong)
}
