//! Whether a controller is set up for the robot.

use std::collections::BTreeMap;

use super::fault::MotionFault;
use super::settings::MotionSettings;

/// The controller's settings by number.
pub(super) type SettingsTable = BTreeMap<u16, String>;

/// What a setting must be.
enum Requirement {
    Exactly(f64),
    AtLeast(f64),
    Bits(u32),
    Positive,
}

struct SettingRule {
    number: u16,
    meaning: &'static str,
    need: Requirement,
    /// Versions without this setting are all right.
    optional: bool,
}

/// Refuses a controller whose settings are not those that the robot needs.
pub(super) fn check(table: &SettingsTable, settings: &MotionSettings) -> Result<(), MotionFault> {
    // GRBL itself, and what follows it closely, has its homing passes compiled in, and `$22` only turns homing on.
    let plain = PASSES.iter().all(|pass| !table.contains_key(pass));
    rules(settings, plain).iter().try_for_each(|rule| rule.check(table))?;
    if plain { Ok(()) } else { all_axes_home(table) }
}

/// The settings that say which axes home in each pass.
const PASSES: [u16; 4] = [44, 45, 46, 47];

fn rules(settings: &MotionSettings, plain: bool) -> Vec<SettingRule> {
    let rule = |number, meaning, need| SettingRule { number, meaning, need, optional: false };
    let optional = |number, meaning, need| SettingRule { number, meaning, need, optional: true };
    let homing = if plain { 1 } else { 13 };
    let mut rules = vec![
        // Whether reports have machine positions shows in the reports.
        optional(10, "fields of the status report: 1 machine position", Requirement::Bits(1)),
        rule(13, "report in inches", Requirement::Exactly(0.0)),
        rule(20, "soft limits", Requirement::Exactly(1.0)),
        rule(21, "hard limits", Requirement::Bits(1)),
        rule(22, "homing: 1 on, 4 required after the start, 8 makes the switch 0", Requirement::Bits(homing)),
        rule(23, "axes that home downwards", Requirement::Exactly(f64::from(settings.homing_directions))),
        optional(376, "axes that turn instead of moving in a line", Requirement::Exactly(0.0)),
    ];
    if settings.hold_when_idle {
        rules.push(rule(1, "delay before the motors are switched off at rest, 255 never", Requirement::Exactly(255.0)));
    }
    for axis in 0..4 {
        rules.push(rule(110 + axis, "greatest speed of an axis, mm/min", Requirement::Positive));
        rules.push(rule(120 + axis, "greatest acceleration of an axis, mm/s²", Requirement::Positive));
        rules.push(rule(130 + axis, "travel of an axis, mm", Requirement::AtLeast(settings.travel_m * 1e3)));
    }
    rules
}

impl SettingRule {
    fn check(&self, table: &SettingsTable) -> Result<(), MotionFault> {
        let value = number(table, self.number);
        let missing = self.optional && !table.contains_key(&self.number);
        if missing || value.is_some_and(|value| self.need.met(value)) {
            return Ok(());
        }
        let found = table.get(&self.number).map_or("nothing", String::as_str).to_owned();
        Err(MotionFault::WrongSetting {
            number: self.number,
            meaning: self.meaning,
            found,
            expected: self.need.description(),
        })
    }
}

impl Requirement {
    fn met(&self, value: f64) -> bool {
        match *self {
            Requirement::Exactly(wanted) => value == wanted,
            // The controller rounds its settings to micrometres.
            Requirement::AtLeast(least) => value >= least - 1e-3,
            Requirement::Bits(bits) => value >= 0.0 && (value as u32) & bits == bits,
            Requirement::Positive => value > 0.0,
        }
    }

    fn description(&self) -> String {
        match self {
            Requirement::Exactly(wanted) => wanted.to_string(),
            Requirement::AtLeast(least) => format!("at least {least}"),
            Requirement::Bits(bits) => format!("a sum that includes {bits}"),
            Requirement::Positive => "a number above 0".to_owned(),
        }
    }
}

/// The axes that home in each pass stand in `$44` and the settings after it; together they must be all four.
fn all_axes_home(table: &SettingsTable) -> Result<(), MotionFault> {
    let homed = PASSES.into_iter().filter_map(|pass| number(table, pass)).fold(0, |all, axes| all | axes as u32);
    if homed & 15 == 15 {
        return Ok(());
    }
    let found = PASSES
        .into_iter()
        .filter_map(|pass| Some(format!("${pass}={}", table.get(&pass)?)))
        .collect::<Vec<_>>()
        .join(" ");
    let expected = "1, 2, 4 and 8 (X, Y, Z and A) in one of $44 to $47".to_owned();
    Err(MotionFault::WrongSetting { number: 44, meaning: "axes that home in each pass", found, expected })
}

/// The value of a setting as a number; what some versions say about it behind it is left out.
pub(super) fn number(table: &SettingsTable, number: u16) -> Option<f64> {
    let value = table.get(&number)?.split_whitespace().next()?;
    value.parse().ok().filter(|value: &f64| value.is_finite())
}
