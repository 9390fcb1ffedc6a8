//! Units of other people's files.

use serde::{Deserialize, Serialize};

use super::iso8601;

/// Unit of a length.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum LengthUnit {
    /// Metres.
    #[default]
    M,
    /// Centimetres.
    Cm,
    /// Millimetres.
    Mm,
    /// Micrometres.
    Um,
    /// Inches.
    In,
}

impl LengthUnit {
    pub(crate) const ALL: [LengthUnit; 5] =
        [LengthUnit::M, LengthUnit::Cm, LengthUnit::Mm, LengthUnit::Um, LengthUnit::In];

    /// The unit of commands of this length.
    pub(crate) fn of_commands(self) -> CommandUnit {
        match self {
            LengthUnit::M => CommandUnit::M,
            LengthUnit::Cm => CommandUnit::Cm,
            LengthUnit::Mm => CommandUnit::Mm,
            LengthUnit::Um => CommandUnit::Um,
            LengthUnit::In => CommandUnit::In,
        }
    }

    /// Metres in one of it.
    pub fn metres(self) -> f64 {
        match self {
            LengthUnit::M => 1.0,
            LengthUnit::Cm => 1e-2,
            LengthUnit::Mm => 1e-3,
            LengthUnit::Um => 1e-6,
            LengthUnit::In => 0.0254,
        }
    }
}

/// Unit of a mass.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum MassUnit {
    /// Kilograms.
    #[default]
    Kg,
    /// Grams.
    G,
}

impl MassUnit {
    /// Kilograms in one of it.
    pub fn kilograms(self) -> f64 {
        match self {
            MassUnit::Kg => 1.0,
            MassUnit::G => 1e-3,
        }
    }
}

/// Unit of a time.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum TimeUnit {
    /// Seconds.
    #[default]
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
    /// Minutes.
    Min,
    /// Hours.
    H,
    /// Time of day without a date, such as `09:59:59.600`; after midnight the next day begins.
    TimeOfDay,
    /// Date and time of day, such as `2024-03-01T10:15:30.123456+01:00`.
    Iso8601,
}

impl TimeUnit {
    /// Nanoseconds in one of it; none for what is written as a date or a time of day.
    fn in_nanoseconds(self) -> Option<i128> {
        match self {
            TimeUnit::Ns => Some(1),
            TimeUnit::Us => Some(1_000),
            TimeUnit::Ms => Some(1_000_000),
            TimeUnit::S => Some(1_000_000_000),
            TimeUnit::Min => Some(60_000_000_000),
            TimeUnit::H => Some(3_600_000_000_000),
            TimeUnit::TimeOfDay | TimeUnit::Iso8601 => None,
        }
    }

    /// Whether a time in it begins anew at midnight.
    pub(crate) fn is_of_day(self) -> bool {
        matches!(self, TimeUnit::TimeOfDay | TimeUnit::H)
    }

    /// The time written as `text`, a decimal number in this unit with `.`, in whole nanoseconds:
    /// stamps since 1970 have more digits than a double holds. None for a date, and for what is no
    /// number.
    pub(crate) fn nanoseconds(self, text: &str) -> Option<i64> {
        if self == TimeUnit::TimeOfDay {
            return iso8601::time_of_day_ns(text);
        }
        let scale = self.in_nanoseconds()?;
        let (negative, digits) = match text.as_bytes().first()? {
            b'-' => (true, &text[1..]),
            b'+' => (false, &text[1..]),
            _ => (false, text),
        };
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let is_number = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        if !(is_number(whole) && is_number(fraction)) || whole.len() + fraction.len() == 0 {
            // Exponents and the like.
            let scaled = text.parse::<f64>().ok()? * scale as f64;
            return (scaled.abs() < 2f64.powi(62)).then_some(scaled.round() as i64);
        }
        let whole =
            if whole.is_empty() { 0 } else { whole.parse::<i128>().ok()?.checked_mul(scale)? };
        let fraction_ns = format!("0.{fraction}").parse::<f64>().ok()? * scale as f64;
        let magnitude = i64::try_from(whole + fraction_ns.round() as i128).ok()?;
        Some(if negative { -magnitude } else { magnitude })
    }
}

/// Unit of a command.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum CommandUnit {
    /// Metres.
    #[default]
    M,
    /// Centimetres.
    Cm,
    /// Millimetres.
    Mm,
    /// Micrometres.
    Um,
    /// Inches.
    In,
    /// Newtons: the commands are tensions.
    N,
    /// Millinewtons.
    Mn,
    /// Radians.
    Rad,
    /// Degrees.
    Deg,
    /// Revolutions.
    Rev,
    /// Counts of an encoder, or steps of a motor.
    Count,
}

impl CommandUnit {
    /// Its word in a map.
    pub(crate) fn word(self) -> String {
        format!("`{}`", format!("{self:?}").to_lowercase())
    }

    /// How it is written in the files of loggers.
    pub(crate) fn spellings(self) -> &'static [&'static str] {
        match self {
            CommandUnit::M => &["m", "meter", "meters", "metre", "metres"],
            CommandUnit::Cm => &["cm"],
            CommandUnit::Mm => &["mm"],
            CommandUnit::Um => &["um", "µm", "μm"],
            CommandUnit::In => &["in", "inch", "inches"],
            CommandUnit::N => &["N"],
            CommandUnit::Mn => &["mN"],
            CommandUnit::Rad => &["rad"],
            CommandUnit::Deg => &["deg", "°", "degree", "degrees"],
            CommandUnit::Rev => &["rev", "turn", "turns"],
            CommandUnit::Count => &["count", "counts", "tick", "ticks", "step", "steps", "pulse"],
        }
    }
}

/// Unit of an angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AngleUnit {
    /// Degrees.
    Deg,
    /// Radians.
    Rad,
}

impl AngleUnit {
    /// Radians in one of it.
    pub fn radians(self) -> f64 {
        match self {
            AngleUnit::Deg => std::f64::consts::PI / 180.0,
            AngleUnit::Rad => 1.0,
        }
    }
}

/// What a command's number measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CommandKind {
    Length,
    Tension,
    Angle,
    Count,
}

impl CommandUnit {
    /// What it measures, and how many metres, newtons, radians or counts are in one of it.
    pub(crate) fn factor(self) -> (CommandKind, f64) {
        use std::f64::consts::PI;
        match self {
            CommandUnit::M => (CommandKind::Length, 1.0),
            CommandUnit::Cm => (CommandKind::Length, 1e-2),
            CommandUnit::Mm => (CommandKind::Length, 1e-3),
            CommandUnit::Um => (CommandKind::Length, 1e-6),
            CommandUnit::In => (CommandKind::Length, 0.0254),
            CommandUnit::N => (CommandKind::Tension, 1.0),
            CommandUnit::Mn => (CommandKind::Tension, 1e-3),
            CommandUnit::Rad => (CommandKind::Angle, 1.0),
            CommandUnit::Deg => (CommandKind::Angle, PI / 180.0),
            CommandUnit::Rev => (CommandKind::Angle, 2.0 * PI),
            CommandUnit::Count => (CommandKind::Count, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_keep_every_nanosecond() {
        let read = |unit: TimeUnit, text| unit.nanoseconds(text);
        assert_eq!(read(TimeUnit::Ns, "1732633000123456789"), Some(1_732_633_000_123_456_789));
        assert_eq!(read(TimeUnit::S, "1732633000.123456789"), Some(1_732_633_000_123_456_789));
        assert_eq!(read(TimeUnit::Ms, "-1.5"), Some(-1_500_000));
        assert_eq!(read(TimeUnit::Us, ".25"), Some(250));
        assert_eq!(read(TimeUnit::S, "1.2e-3"), Some(1_200_000));
        assert_eq!(read(TimeUnit::H, "9.5"), Some(34_200_000_000_000));
        assert_eq!(read(TimeUnit::Min, "15"), Some(900_000_000_000));
        assert_eq!(read(TimeUnit::TimeOfDay, "09:59:59.6"), Some(35_999_600_000_000));
        for bad in ["", "-", ".", "1,5", "12:00", "1e40", "nan"] {
            assert_eq!(read(TimeUnit::S, bad), None, "{bad}");
        }
        assert_eq!(read(TimeUnit::Iso8601, "1732633000"), None);
    }
}
