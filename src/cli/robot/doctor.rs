//! `spinebench doctor`.

use super::session::read_hardware_plant;
use crate::cli::{CommandError, CommandResult};
use clap::Args;
use spinebench::base::{Plant, Point3, Seed, distance_m};
use spinebench::hardware::grbl::{AXIS_NAMES, codes};
use spinebench::hardware::tracking::TrackingStatus;
use spinebench::plants::hardware::{Diagnostics, Hardware, HardwareOptions};
use std::path::PathBuf;

/// Control step of the check, s.
const STEP_S: f64 = 0.2;
/// Observation time of the tracker, s.
const WATCH_S: f64 = 2.0;
/// Test displacement of each tendon, metres, in steps of a third of it.
const PULL_M: f64 = 0.006;
/// Smallest motion of the tip that counts as motion, metres.
const MIN_MOTION_M: f64 = 0.002;

/// Largest ratio, either way, and largest angle, degrees, between the measured and the predicted
/// motion of one tendon: sag, creep and a tilted base change both by so much, swapped tendons by
/// ninety degrees and more.
const ONE_TENDON: Agreement = Agreement { max_ratio: 3.0, max_apart_deg: 60.0 };

/// The same of two opposite tendons, whose difference sag and creep do not change: beyond it, the
/// model's dimensions, the screws' `$100`… or the tracker's unit are wrong, or the alignment.
const PAIR: Agreement = Agreement { max_ratio: 1.6, max_apart_deg: 30.0 };

/// Check a robot's hardware: ports, versions, settings, rates, frames. Moves nothing without
/// --move.
#[derive(Args)]
pub(crate) struct DoctorCommand {
    /// Plant file with `hardware:`.
    #[arg(long, value_name = "PLANT.yaml")]
    plant: PathBuf,
    /// Home the axes and pull each tendon by 6 mm, to check that the tip moves as the model
    /// predicts.
    #[arg(long = "move")]
    moving: bool,
}

impl DoctorCommand {
    pub(crate) fn execute(self) -> CommandResult {
        let options = read_hardware_plant(&self.plant)?;
        let mut plant = Hardware::open(&options, STEP_S, Seed(1)).map_err(CommandError::failed)?;
        let diagnostics = plant.run_diagnostics(WATCH_S);
        let mut wrong = report(&diagnostics, &options);
        if self.moving {
            wrong += test_tendons(&mut plant)?;
        } else {
            println!(
                "       nothing was moved; use --move to home the axes and pull each tendon by 6 mm"
            );
        }
        if wrong > 0 {
            Err(CommandError::Failed(format!("failed checks: {wrong}")))
        } else {
            Ok(())
        }
    }
}

/// Limits of the agreement of two motions.
struct Agreement {
    max_ratio: f64,
    max_apart_deg: f64,
}

fn length_m(motion_m: &Point3) -> f64 {
    distance_m(motion_m, &[0.0; 3])
}

/// Angle between two directions, degrees.
fn angle_deg(one: &Point3, other: &Point3) -> f64 {
    let dot: f64 = one.iter().zip(other).map(|(a, b)| a * b).sum();
    (dot / (length_m(one) * length_m(other))).clamp(-1.0, 1.0).acos().to_degrees()
}

/// Half the difference of two motions.
fn half_difference(one: &Point3, other: &Point3) -> Point3 {
    std::array::from_fn(|axis| 0.5 * (one[axis] - other[axis]))
}

impl Agreement {
    /// Prints how far the tip moved and in which direction, against the prediction; returns 1 if
    /// either is wrong.
    fn print(&self, what: &str, moved_m: &Point3, predicted_m: &Point3) -> usize {
        let (ratio, apart_deg) =
            (length_m(moved_m) / length_m(predicted_m), angle_deg(moved_m, predicted_m));
        let min_ratio = 1.0 / self.max_ratio;
        let sized =
            length_m(moved_m) > MIN_MOTION_M && (min_ratio..=self.max_ratio).contains(&ratio);
        let directed = apart_deg <= self.max_apart_deg;
        let advice = match (sized, directed) {
            (true, true) => String::new(),
            (false, true) => format!(
                "; expected a ratio of {min_ratio:.2} to {}: check the model's dimensions and \
                 stiffness, $100 to $103 and the tracker's unit",
                self.max_ratio
            ),
            (_, false) => format!(
                "; expected at most {} degrees: check the order of the tendons, up_axis and the \
                 alignment (`spinebench align`)",
                self.max_apart_deg
            ),
        };
        let words = format!(
            "{what}: pulled {:.0} mm, tip moved {:.1} mm, predicted {:.1} mm, ratio {ratio:.2}, \
             {apart_deg:.0} degrees apart{advice}",
            PULL_M * 1e3,
            length_m(moved_m) * 1e3,
            length_m(predicted_m) * 1e3
        );
        print_check(sized && directed, &words)
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
        "until then no program can move the robot"
    } else {
        "the next program that moves the robot (`collect`, `doctor --move`) resets and homes it"
    };
    format!("controller: alarm {number}: {} {clears}", codes::alarm(code))
}

/// Names limit switches that are closed, and what opens them.
fn closed_text(axes: &str) -> String {
    format!(
        "controller: limit switch closed: {axes}; homing moves an axis off its switch (`doctor \
         --move` resets, unlocks and homes); if it stays closed, check the switch, its cable and \
         $5, or turn the screw by hand with the power off"
    )
}

/// Names the body that is hidden, or whatever else is wrong with the frames.
fn untracked_text(tracking: &TrackingStatus) -> String {
    let why = tracking.fault.as_deref().or(tracking.unseen);
    let why = why.map(|why| format!(" ({why})")).unwrap_or_default();
    format!("tip: not tracked{why}, expected both bodies in view")
}

fn report(diagnostics: &Diagnostics, options: &HardwareOptions) -> usize {
    let (rate_hz, near_m) = (options.tracking.rate_hz, options.safety.tip_from_model_m);
    let Diagnostics {
        controller,
        alarm,
        closed_switches,
        homed,
        position_mm,
        server,
        tracking,
        tip,
        home_m,
        real_time,
    } = diagnostics;
    let mut wrong = print_check(true, &format!("controller: {controller}"));
    if let Some(code) = *alarm {
        wrong += print_check(false, &alarm_text(code));
    }
    let closed: Vec<String> = AXIS_NAMES
        .iter()
        .zip(closed_switches)
        .filter(|(_, closed)| **closed)
        .map(|(name, _)| name.to_string())
        .collect();
    if !closed.is_empty() {
        wrong += print_check(false, &closed_text(&closed.join(", ")));
    }
    let position = position_mm.map(|mm| format!("{mm:.3}")).join(", ");
    wrong += print_check(
        true,
        &format!("axes: {}, position {position} mm", if *homed { "homed" } else { "not homed" }),
    );
    wrong += print_check(true, &format!("tracker: {server}"));
    wrong += report_frames(tracking, rate_hz);
    match tip {
        None => wrong += print_check(false, &untracked_text(tracking)),
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
        let words = if *granted {
            "granted"
        } else {
            "not granted: other programs can delay commands; see docs/reference/hardware.md"
        };
        println!("       real-time priority: {words}");
    }
    wrong
}

/// Reports rate, losses, delays and sources of the frames.
fn report_frames(tracking: &TrackingStatus, rate_hz: f64) -> usize {
    let rate = tracking.rate_hz.unwrap_or(0.0);
    let mut wrong = print_check(
        (rate - rate_hz).abs() < 0.05 * rate_hz,
        &format!("frames: {rate:.1} Hz, expected {rate_hz}"),
    );
    let lost = tracking.lost as f64 / (tracking.lost + tracking.received).max(1) as f64;
    wrong +=
        print_check(lost < 0.05, &format!("frames lost: {:.1} %, expected below 5", 100.0 * lost));
    let jitter_ms = tracking.latency_jitter_s * 1e3;
    wrong += print_check(
        jitter_ms < 20.0,
        &format!("frame jitter: {jitter_ms:.1} ms, expected below 20"),
    );
    wrong += print_check(
        tracking.foreign == 0,
        &format!("frames from other servers: {}, expected 0", tracking.foreign),
    );
    if let Some((_, sources)) = &tracking.second_source_last {
        wrong += print_check(false, &format!("two sources of frames: {sources}; stop one of them"));
    }
    wrong += print_check(
        tracking.malformed == 0,
        &format!("unreadable frames: {}, expected 0", tracking.malformed),
    );
    wrong
}

/// Homes the robot and pulls each tendon; returns the number of motions that are not as the model
/// predicts.
fn test_tendons(plant: &mut Hardware) -> Result<usize, CommandError> {
    let failed = |error: spinebench::base::PlantError| CommandError::Failed(error.to_string());
    let mut wrong = 0;
    let home_m = plant.reset(Seed(1)).map_err(failed)?.tip_m;
    // The difference of two predictions: that of home errs by what gravity and the base differ from
    // the model.
    let predicted_home_m = plant.expected_m();
    let between = |from_m: &Point3, to_m: &Point3| -> Point3 {
        std::array::from_fn(|axis| to_m[axis] - from_m[axis])
    };
    let mut motions = Vec::new();
    for tendon in 0..plant.tendons() {
        let mut seen_m = [f64::NAN; 3];
        // Three steps to the displacement, and three ticks to come to rest.
        for share in [1.0, 2.0, 3.0, 3.0, 3.0, 3.0] {
            let mut pulls_m = vec![0.0; plant.tendons()];
            pulls_m[tendon] = PULL_M * share / 3.0;
            pulls_m[(tendon + 2) % 4] = -PULL_M * share / 3.0;
            seen_m = plant.step(&pulls_m).map_err(failed)?.tip_m;
        }
        let (moved_m, predicted_m) =
            (between(&home_m, &seen_m), between(&predicted_home_m, &plant.expected_m()));
        wrong += ONE_TENDON.print(&format!("tendon {}", tendon + 1), &moved_m, &predicted_m);
        motions.push((moved_m, predicted_m));
        plant.reset(Seed(1)).map_err(failed)?;
    }
    for (first, (one, opposite)) in motions.iter().zip(&motions[2..]).enumerate() {
        let what = format!("tendons {} and {}", first + 1, first + 3);
        let (moved_m, predicted_m) =
            (half_difference(&one.0, &opposite.0), half_difference(&one.1, &opposite.1));
        wrong += PAIR.print(&what, &moved_m, &predicted_m);
    }
    let timing = plant.timing();
    let (latency_ms, jitter_ms) =
        (1e3 * timing.latency.quantile_s(0.99), 1e3 * timing.jitter.quantile_s(0.99));
    wrong += print_check(
        latency_ms <= 2.0,
        &format!("command latency: 99 % within {latency_ms:.2} ms, expected 2"),
    );
    wrong += print_check(
        jitter_ms <= 5.0,
        &format!("tick jitter: 99 % within {jitter_ms:.2} ms, expected 5"),
    );
    Ok(wrong)
}
