//! Options of a hardware plant in its YAML file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Hardware;
use crate::base::{BadOption, Plant, Seed, is_default};
use crate::effects::{DriveGains, EffectSpec, Model};
use crate::hardware::axes::{AXES, AxesOptions};
use crate::hardware::grbl::MotionSettings;
use crate::hardware::safety::SafetyLimits;
use crate::hardware::tracking::{RigidPose, TrackingSettings};
use crate::plants::PlantOptions;

/// Four lead screws, a tracker, and a model of the robot between them (docs/reference/hardware.md).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HardwareOptions {
    /// Name of the robot; a stop is stored and logged under it.
    pub name: String,
    /// Model of the robot: predicts the motion of following tendons and the tip position.
    pub model: Model,
    /// The motors.
    #[serde(default)]
    pub motion: MotionSettings,
    /// Positions of the lead screws at home.
    #[serde(default)]
    pub axes: AxesOptions,
    /// The tracker.
    #[serde(default)]
    pub tracking: TrackingSettings,
    /// Limits of commands, and conditions that hold or stop the robot.
    #[serde(default)]
    pub safety: SafetyLimits,
    /// Rest at home before a trial, s.
    #[serde(default = "settle_s")]
    pub settle_s: f64,
    /// Simulators of the motors and the tracker with a simulated robot, used with the same drivers
    /// instead of the real devices.
    #[serde(default)]
    pub rehearsal: Option<RehearsalOptions>,
    /// Effects that the operator attaches to the robot before a trial, such as a load at the tip.
    #[serde(default)]
    pub attached: Vec<EffectSpec>,
}

fn settle_s() -> f64 {
    2.0
}

/// The simulated robot of a rehearsal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RehearsalOptions {
    /// Model of the simulated robot.
    pub model: Model,
    /// Standard deviation of the tracking noise per axis, metres.
    #[serde(default)]
    pub noise_m: f64,
    /// Share of the tracker's frames that are lost.
    #[serde(default)]
    pub loss: f64,
    /// Frames are delayed by random times up to this one, s.
    #[serde(default, skip_serializing_if = "is_default")]
    pub jitter_s: f64,
    /// Gaps without frames of this length, s, one every three seconds.
    #[serde(default, skip_serializing_if = "is_default")]
    pub gap_s: f64,
    /// True pose of the robot's base frame in the base body's frame; null: the pose in
    /// `tracking.alignment`. For testing `spinebench align`.
    #[serde(default)]
    pub alignment: Option<RigidPose>,
}

impl HardwareOptions {
    /// The robot `name` with `model` and default settings.
    pub fn of(name: &str, model: Model) -> HardwareOptions {
        HardwareOptions {
            name: name.to_owned(),
            model,
            motion: MotionSettings::default(),
            axes: AxesOptions::default(),
            tracking: TrackingSettings::default(),
            safety: SafetyLimits::default(),
            settle_s: settle_s(),
            rehearsal: None,
            attached: Vec::new(),
        }
    }

    /// Refuses an answer time after which the guard has stopped the robot already.
    fn check_reply_timeout(&self) -> Result<(), BadOption> {
        let (reply_s, stop_s) =
            (self.motion.reply_timeout_s, self.motion.late_s + self.safety.hold_stop_s);
        let found = format!(
            "{reply_s} s with late_s {} and hold_stop_s {}",
            self.motion.late_s, self.safety.hold_stop_s
        );
        let expected = "at most motion.late_s + safety.hold_stop_s, when a held robot is stopped";
        BadOption::unless(reply_s <= stop_s, "reply_timeout_s", found, expected)
    }
}

impl PlantOptions for HardwareOptions {
    const MODEL_KEYS: &'static [&'static str] = &["model", "rehearsal.model"];
    const DRIVES_HARDWARE: bool = true;
    const TAKES_EFFECTS: bool = true;

    fn check(&self) -> Result<(), (String, BadOption)> {
        let at = |path: &'static str| move |error: BadOption| (path.to_owned(), error);
        let named = |letter: char| letter.is_ascii_alphanumeric() || "_-".contains(letter);
        if self.name.is_empty() || !self.name.chars().all(named) {
            let expected = "letters, digits, `_` and `-`";
            return Err((
                String::new(),
                BadOption { key: "name", found: self.name.clone(), expected },
            ));
        }
        self.motion.check().map_err(at("motion"))?;
        self.safety.check().map_err(at("safety"))?;
        self.check_reply_timeout().map_err(at("motion"))?;
        self.axes.check(self.safety.travel_m, self.motion.travel_m).map_err(at("axes"))?;
        self.tracking.check().map_err(at("tracking"))?;
        BadOption::unless_positive("settle_s", self.settle_s).map_err(at(""))?;
        self.model.check_written("model")?;
        self.rehearsal.as_ref().map_or(Ok(()), RehearsalOptions::check)
    }

    fn tendons(&self) -> usize {
        AXES
    }

    fn drive_gains(&self) -> BTreeMap<String, DriveGains> {
        self.model.drive_gains()
    }

    fn build(&self, step_s: f64) -> Result<Box<dyn Plant>, String> {
        Ok(Box::new(Hardware::open(self, step_s, Seed(0))?))
    }

    /// A rehearsal can be asked for less noise; a tracker cannot.
    fn remove_noise(&mut self) {
        self.rehearsal.iter_mut().for_each(|rehearsal| rehearsal.noise_m = 0.0);
    }

    fn add_effects(&mut self, effects: &[EffectSpec]) {
        self.attached.extend_from_slice(effects);
    }

    fn travel_m(&self) -> Option<f64> {
        Some(self.safety.travel_m)
    }
}

impl RehearsalOptions {
    fn check(&self) -> Result<(), (String, BadOption)> {
        self.check_numbers().map_err(|error| ("rehearsal".to_owned(), error))?;
        self.model.check_written("rehearsal.model")
    }

    fn check_numbers(&self) -> Result<(), BadOption> {
        BadOption::unless_within("noise_m", self.noise_m, 0.0..=0.05, "0 to 0.05 m")?;
        BadOption::unless_within("loss", self.loss, 0.0..1.0, "0 to less than 1")?;
        BadOption::unless_within("jitter_s", self.jitter_s, 0.0..=1.0, "0 to 1 s")?;
        BadOption::unless_within("gap_s", self.gap_s, 0.0..=1.0, "0 to 1 s")?;
        self.alignment.map_or(Ok(()), |alignment| alignment.check("alignment"))
    }
}
