//! A model: a robot and the effects added to it.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::base::{BadOption, TendonLayout};
use crate::effects::robot::units::{ANGLE, COMPLIANCE, FORCE, MASS, SHIFT};
use crate::effects::{
    Effect, EffectSpec, ObstacleSpec, Robot, Seek, TendonDrive, Tracking, check_drives,
};
use crate::rod::{Rod, RodParams};

/// A robot and the effects on it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// The robot as built.
    pub robot: Robot,
    /// Effects, in the order in which they act.
    #[serde(default)]
    pub effects: Vec<EffectSpec>,
    /// Obstacles that the robot may touch.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<ObstacleSpec>,
    /// Tracked points besides the tip.
    #[serde(default, skip_serializing_if = "Tracking::is_default")]
    pub tracking: Tracking,
    /// Drives by name, if commands are those of drives: the name in the columns `drive_NAME_rad` or
    /// `drive_NAME_m` of a recording.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub drives: BTreeMap<String, TendonDrive>,
}

impl Model {
    /// Refuses numbers out of range.
    ///
    /// # Errors
    /// The path of the key (such as `robot.backbone` or `effects[0].tip_load`) and the expected
    /// range.
    pub fn check(&self) -> Result<(), (String, BadOption)> {
        self.robot.check().map_err(|(path, error)| (below("robot", &path), error))?;
        self.tracking.check(self.robot.backbone.length_m)?;
        check_drives(&self.drives, self.robot.tendons.angles_deg.len())?;
        check_effects(&self.effects, &self.robot.tendon_layout())
            .map_err(|(index, name, error)| (format!("effects[{index}].{name}"), error))?;
        self.check_obstacles()
    }

    fn check_obstacles(&self) -> Result<(), (String, BadOption)> {
        for (index, obstacle) in self.obstacles.iter().enumerate() {
            obstacle
                .check()
                .map_err(|(shape, error)| (below(&format!("obstacles[{index}]"), shape), error))?;
        }
        // A found obstacle may reach a little into the robot: only one that somebody has written is
        // held to this.
        let mut rod = self.rod(&[]);
        rod.contact.obstacles.truncate(self.obstacles.len());
        let Some(home) = Rod::touched_at_home(&rod) else { return Ok(()) };
        let path = format!("obstacles[{}]", home.obstacle);
        let found = format!(
            "{:.3} mm of it in the straight robot, {:.4} m from its base",
            1e3 * home.penetration_m,
            home.s_m
        );
        let key = self.obstacles[home.obstacle].shape_name();
        Err((path, BadOption { key, found, expected: "an obstacle outside the straight robot" }))
    }

    /// Refuses numbers that no robot has, as a wrong unit makes them. Only what somebody has
    /// written is held to these bounds: a fit may cross them.
    ///
    /// # Errors
    /// As [`Model::check`].
    pub fn check_units(&self) -> Result<(), (String, BadOption)> {
        self.unit_faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// All numbers that no robot has, each with its path; of the effects the first.
    pub fn unit_faults(&self) -> Vec<(String, BadOption)> {
        let robot = self.robot.unit_faults().into_iter();
        let effects = check_effect_units(&self.effects)
            .map_err(|(index, name, error)| (format!("effects[{index}].{name}"), error));
        robot.map(|(path, error)| (below("robot", &path), error)).chain(effects.err()).collect()
    }

    /// The number that is furthest outside the range of most robots, likely one in another unit, in
    /// a sentence about the model in `file`; `None` where all are usual.
    pub fn unusual_number(&self, file: &Path) -> Option<String> {
        let (key, value) = self.robot.suspect()?;
        let file = file.display();
        Some(format!("{file}: {key}: found {value}, an unusual value; check its unit"))
    }

    /// Both checks; the path of the key begins with `at`.
    ///
    /// # Errors
    /// As [`Model::check`].
    pub fn check_written(&self, at: &str) -> Result<(), (String, BadOption)> {
        let checked = self.check_units().and_then(|()| self.check());
        checked.map_err(|(path, error)| (format!("{at}.{path}"), error))
    }

    /// The rod with all effects, then `extra` ones; payloads are applied last.
    pub fn rod(&self, extra: &[EffectSpec]) -> RodParams {
        let mut rod = self.robot.rod();
        rod.rested_s = self.tracking.rested_s.unwrap_or(f64::INFINITY);
        rod.contact.obstacles = self.obstacles.iter().filter_map(ObstacleSpec::for_rod).collect();
        let (payloads, others): (Vec<_>, Vec<_>) =
            self.effects(extra).into_iter().partition(|effect| effect.is_payload());
        others.iter().chain(&payloads).for_each(|effect| effect.modify_rod(&mut rod));
        rod
    }

    /// Whether a pose at rest depends on those before it: histories and friction.
    pub fn remembers_at_rest(&self) -> bool {
        !self.rod(&[]).moment_laws.is_empty()
            || self.effects.iter().any(|effect| effect.build().has_memory_at_rest())
    }

    /// The effects, built, `extra` ones last.
    pub fn effects(&self, extra: &[EffectSpec]) -> Vec<Box<dyn Effect>> {
        self.effects.iter().chain(extra).map(EffectSpec::build).collect()
    }
}

/// The key `path` below `top`.
fn below(top: &str, path: &str) -> String {
    if path.is_empty() { top.to_owned() } else { format!("{top}.{path}") }
}

/// Refuses parameters that no robot has, as a wrong unit makes them.
///
/// # Errors
/// As [`check_effects`].
pub fn check_effect_units(effects: &[EffectSpec]) -> Result<(), (usize, &'static str, BadOption)> {
    for (index, spec) in effects.iter().enumerate() {
        let values = serde_json::to_value(spec).unwrap_or_default();
        let card = spec.card();
        for parameter in card.parameters {
            let quantity = match parameter.unit {
                "kg" => &MASS,
                "N" => &FORCE,
                "m" => &SHIFT,
                "rad" => &ANGLE,
                "m/N" => &COMPLIANCE,
                _ => continue,
            };
            // A place on the robot has a check of its own; one in the world may be anywhere.
            if matches!(parameter.seek, Seek::Place | Seek::Distance(_) | Seek::Located(_)) {
                continue;
            }
            let key = parameter.vector();
            let numbers = match &values[card.name][key] {
                Value::Array(components) => components.iter().filter_map(Value::as_f64).collect(),
                number => Vec::from_iter(number.as_f64()),
            };
            numbers
                .into_iter()
                .try_for_each(|number| quantity.check(key, number))
                .map_err(|error| (index, card.name, error))?;
        }
    }
    Ok(())
}

/// Refuses parameters out of range and tendons and segments that the robot does not have.
///
/// # Errors
/// Index and name of the first bad effect, and the expected range.
pub fn check_effects(
    effects: &[EffectSpec],
    layout: &TendonLayout,
) -> Result<(), (usize, &'static str, BadOption)> {
    for (index, spec) in effects.iter().enumerate() {
        let effect = spec.build();
        let tendon = effect.tendon().unwrap_or_default();
        let segment = effect.segment().unwrap_or_default();
        let (tendons, segments) =
            (layout.segments.iter().map(Vec::len).sum(), layout.segments.len());
        let expected = "a segment of this robot: where some tendons end";
        effect
            .check()
            .and_then(|()| {
                BadOption::unless(tendon <= tendons, "tendon", tendon, "a tendon of this robot")
            })
            .and_then(|()| BadOption::unless(segment <= segments, "segment", segment, expected))
            .map_err(|error| (index, spec.card().name, error))?;
    }
    Ok(())
}
