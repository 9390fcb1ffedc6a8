//! Checks that a controller is configured for the robot.

use std::collections::BTreeMap;
use std::fmt;

use super::fault::MotionFault;
use super::settings::MotionSettings;

/// The controller's settings by number.
pub(super) type SettingsTable = BTreeMap<u16, String>;

/// A setting that does not meet the requirements, and the lines that set it right.
#[derive(Clone, Debug, PartialEq)]
pub struct WrongSetting {
    /// Number of the setting.
    pub number: u16,
    /// Its meaning.
    pub meaning: &'static str,
    /// Its value, `nothing` if it is missing.
    pub found: String,
    /// Its required value.
    pub expected: String,
    /// Lines to send to the controller, such as `$20=1`.
    pub commands: Vec<String>,
}

impl fmt::Display for WrongSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let WrongSetting { number, meaning, found, expected, .. } = self;
        write!(
            f,
            "setting ${number} ({meaning}) of the controller: found {found}, expected {expected}"
        )
    }
}

/// Describes all wrong settings, and the lines that set them right in an order in which the
/// controller accepts them.
pub(super) fn describe(wrong: &[WrongSetting]) -> String {
    let problems: Vec<String> = wrong.iter().map(ToString::to_string).collect();
    let mut commands: Vec<&str> =
        wrong.iter().flat_map(|setting| &setting.commands).map(String::as_str).collect();
    // Soft limits are refused before homing is on.
    commands.sort_by_key(|command| !command.starts_with("$22="));
    let remedy =
        format!("send {} with a terminal program, then connect again", commands.join("  "));
    match &problems[..] {
        [one] => format!("{one}; {remedy}"),
        all => format!("{} settings are wrong:\n  {};\n  {remedy}", all.len(), all.join("\n  ")),
    }
}

/// What value a setting must have.
enum Requirement {
    Exactly(f64),
    AtLeast(f64),
    Bits(u32),
    /// Above 0; the value is recommended.
    Positive(f64),
}

struct SettingRule {
    number: u16,
    meaning: &'static str,
    requirement: Requirement,
    /// Firmware without this setting is accepted.
    optional: bool,
}

/// Refuses a controller whose settings do not meet the robot's requirements; names all of them.
pub(super) fn check(table: &SettingsTable, settings: &MotionSettings) -> Result<(), MotionFault> {
    // Plain GRBL has its homing passes compiled in; there `$22` only turns homing on.
    let plain = PASSES.iter().all(|pass| !table.contains_key(pass));
    let mut wrong: Vec<WrongSetting> =
        rules(settings, plain).iter().filter_map(|rule| rule.wrong(table)).collect();
    if !plain {
        wrong.extend(homing_passes(table));
    }
    if wrong.is_empty() { Ok(()) } else { Err(MotionFault::WrongSettings(wrong)) }
}

/// The settings that name the axes of each homing pass.
const PASSES: [u16; 4] = [44, 45, 46, 47];

fn rules(settings: &MotionSettings, plain: bool) -> Vec<SettingRule> {
    let rule = |number, meaning, requirement| SettingRule {
        number,
        meaning,
        requirement,
        optional: false,
    };
    let optional =
        |number, meaning, requirement| SettingRule { number, meaning, requirement, optional: true };
    // 1 + 4 + 8, see the meaning of $22 below.
    let homing = if plain { 1 } else { 13 };
    let mut rules = vec![
        // Optional: the reports themselves show whether they carry machine positions.
        optional(10, "status report fields, 1: machine position", Requirement::Bits(1)),
        rule(13, "reports in inches", Requirement::Exactly(0.0)),
        rule(
            22,
            "homing, 1: on, 4: required after start-up, 8: switches at 0",
            Requirement::Bits(homing),
        ),
        rule(20, "soft limits", Requirement::Exactly(1.0)),
        rule(21, "hard limits", Requirement::Bits(1)),
        rule(
            23,
            "axes that home in negative direction",
            Requirement::Exactly(f64::from(settings.homing_directions)),
        ),
        optional(376, "rotary axes", Requirement::Exactly(0.0)),
    ];
    if settings.hold_when_idle {
        rules.push(rule(
            1,
            "delay before idle motors are switched off, 255: never",
            Requirement::Exactly(255.0),
        ));
    }
    let at_least = |min: f64, recommended: f64| {
        if min > 0.0 { Requirement::AtLeast(min) } else { Requirement::Positive(recommended) }
    };
    for axis in 0..4 {
        let speed = at_least(settings.min_speed_mm_min, 3000.0);
        rules.push(rule(110 + axis, "maximum speed of an axis, mm/min", speed));
        rules.push(rule(
            120 + axis,
            "maximum acceleration of an axis, mm/s²",
            at_least(settings.min_acceleration_mm_s2, 500.0),
        ));
        rules.push(rule(
            130 + axis,
            "travel of an axis, mm",
            Requirement::AtLeast(settings.travel_m * 1e3),
        ));
    }
    rules
}

impl SettingRule {
    fn wrong(&self, table: &SettingsTable) -> Option<WrongSetting> {
        let value = number(table, self.number);
        let missing = self.optional && !table.contains_key(&self.number);
        if missing || value.is_some_and(|value| self.requirement.met(value)) {
            return None;
        }
        Some(WrongSetting {
            number: self.number,
            meaning: self.meaning,
            found: table.get(&self.number).map_or("nothing", String::as_str).to_owned(),
            expected: self.requirement.description(),
            commands: vec![format!("${}={}", self.number, self.requirement.right_value(value))],
        })
    }
}

impl Requirement {
    fn met(&self, value: f64) -> bool {
        match *self {
            Requirement::Exactly(exact) => value == exact,
            // The controller rounds its settings to micrometres.
            Requirement::AtLeast(min) => value >= min - 1e-3,
            Requirement::Bits(bits) => value >= 0.0 && (value as u32) & bits == bits,
            Requirement::Positive(_) => value > 0.0,
        }
    }

    fn description(&self) -> String {
        match self {
            Requirement::Exactly(exact) => exact.to_string(),
            Requirement::AtLeast(min) => format!("at least {}", min.ceil()),
            Requirement::Bits(bits) => format!("a bit mask that includes {bits}"),
            Requirement::Positive(_) => "a number above 0".to_owned(),
        }
    }

    /// A value that meets the requirement, given the present one.
    fn right_value(&self, present: Option<f64>) -> f64 {
        match *self {
            Requirement::Exactly(exact) => exact,
            Requirement::AtLeast(min) => min.ceil(),
            Requirement::Bits(bits) => {
                f64::from(present.filter(|value| *value >= 0.0).unwrap_or(0.0) as u32 | bits)
            }
            Requirement::Positive(recommended) => recommended,
        }
    }
}

/// The axes of each homing pass are listed in `$44` and the settings after it; together they must
/// cover all four.
fn homing_passes(table: &SettingsTable) -> Option<WrongSetting> {
    let homed = PASSES
        .into_iter()
        .filter_map(|pass| number(table, pass))
        .fold(0, |all, axes| all | axes as u32);
    if homed & 15 == 15 {
        return None;
    }
    let passes = PASSES
        .into_iter()
        .filter_map(|pass| Some(format!("${pass}={}", table.get(&pass)?)))
        .collect::<Vec<_>>()
        .join(" ");
    let expected = "1, 2, 4 and 8 (X, Y, Z and A) in one of $44 to $47".to_owned();
    Some(WrongSetting {
        number: 44,
        meaning: "axes of a homing pass",
        found: passes,
        expected,
        commands: vec!["$44=15".to_owned()],
    })
}

/// The value of a setting as a number; some firmware appends a description, which is ignored.
pub(super) fn number(table: &SettingsTable, number: u16) -> Option<f64> {
    let value = table.get(&number)?.split_whitespace().next()?;
    value.parse().ok().filter(|value: &f64| value.is_finite())
}
