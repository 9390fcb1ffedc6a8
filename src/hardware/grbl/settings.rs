//! Motion settings: the serial line, and the required configuration of the controller.

use serde::{Deserialize, Serialize};

use crate::base::BadOption;

/// Longest time from a reset to the greeting, beyond the reply time, s.
pub(super) const GREETING_S: f64 = 1.0;

/// Connection to the controller and its required configuration. The controller's own settings are
/// checked, never written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MotionSettings {
    /// Serial port.
    pub port: String,
    /// Speed of the serial line, bits per second.
    pub baud: u32,
    /// Answer time after which the robot is held, s.
    pub late_s: f64,
    /// Answer time after which the robot is stopped, s.
    pub reply_timeout_s: f64,
    /// Longest duration of homing, s.
    pub homing_timeout_s: f64,
    /// Usable length of the screws, from the switches on, metres.
    pub travel_m: f64,
    /// Largest feed that is sent, mm/min along the path in all four axes together.
    pub max_speed_mm_min: f64,
    /// Axes whose switch is at the lower end (`$23`): the sum of 1 for X, 2 for Y, 4 for Z and 8
    /// for A.
    pub homing_directions: u8,
    /// Require that the motors stay energised at rest (`$1=255`), so that the tendons cannot drive
    /// the screws back.
    pub hold_when_idle: bool,
    /// Speed that every axis must reach, mm/min: follows from the limits of the commands, 0 if
    /// there are none.
    #[serde(skip)]
    #[schemars(skip)]
    pub min_speed_mm_min: f64,
    /// Acceleration that every axis must reach, mm/s²: follows from the limits of the commands, 0
    /// if there are none.
    #[serde(skip)]
    #[schemars(skip)]
    pub min_acceleration_mm_s2: f64,
}

impl Default for MotionSettings {
    fn default() -> Self {
        MotionSettings {
            port: "/dev/ttyACM0".to_owned(),
            baud: 115_200,
            late_s: 0.15,
            reply_timeout_s: 0.3,
            homing_timeout_s: 30.0,
            travel_m: 0.06,
            max_speed_mm_min: 3000.0,
            homing_directions: 15,
            hold_when_idle: true,
            min_speed_mm_min: 0.0,
            min_acceleration_mm_s2: 0.0,
        }
    }
}

impl MotionSettings {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`BadOption`] names the first one.
    pub fn check(&self) -> Result<(), BadOption> {
        BadOption::unless(!self.port.is_empty(), "port", "nothing", "the name of a serial port")?;
        BadOption::unless_counted("baud", self.baud as usize)?;
        BadOption::unless_positive("late_s", self.late_s)?;
        BadOption::unless_positive("reply_timeout_s", self.reply_timeout_s)?;
        BadOption::unless_positive("homing_timeout_s", self.homing_timeout_s)?;
        BadOption::unless_positive("travel_m", self.travel_m)?;
        BadOption::unless_positive("max_speed_mm_min", self.max_speed_mm_min)?;
        BadOption::unless_within("homing_directions", self.homing_directions, 0..=15, "0 to 15")
    }

    /// Lowest and highest machine position of an axis, millimetres: the switch is at 0.
    pub fn limits_mm(&self, axis: usize) -> (f64, f64) {
        let travel_mm = self.travel_m * 1e3;
        if self.axis_sign(axis) < 0.0 { (-travel_mm, 0.0) } else { (0.0, travel_mm) }
    }

    /// 1 for an axis whose machine position increases away from its switch, −1 for one whose switch
    /// is at the upper end.
    pub fn axis_sign(&self, axis: usize) -> f64 {
        if self.homing_directions & (1 << axis) == 0 { -1.0 } else { 1.0 }
    }
}
