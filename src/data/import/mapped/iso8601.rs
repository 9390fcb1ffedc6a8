//! Dates with a time of day as ISO 8601 writes them, and as loggers vary it.

/// A date and time of day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct IsoTime {
    /// Nanoseconds since 1970-01-01T00:00 on the clock of the zone.
    local_ns: i64,
    /// Seconds by which the zone is ahead of UTC, where it is written.
    ahead_s: Option<i64>,
}

const NS: i128 = 1_000_000_000;
/// Digits of a fraction that count.
const FRACTION_DIGITS: usize = 9;

impl IsoTime {
    /// Reads `2024-03-01T10:15:30.123456+01:00`. The date may lack its hyphens and the time its
    /// colons; `T` may be a space; seconds, their fraction (after `.` or `,`) and the zone (`Z`,
    /// `+01`, `+0100`, `+01:00`) may be missing.
    pub(crate) fn parse(text: &str) -> Option<IsoTime> {
        let text = text.trim();
        let (date, rest) = text.split_at_checked(text.find(['T', 't', ' '])?)?;
        let rest = rest[1..].trim_start();
        let days = date_days(date)?;
        let (time, ahead_s) = match rest.find(['Z', 'z', '+', '-']) {
            None => (rest, None),
            Some(place) => (rest[..place].trim_end(), Some(zone_s(&rest[place..])?)),
        };
        let local_ns = i128::from(86_400 * days) * NS + i128::from(clock_ns(time)?);
        Some(IsoTime { local_ns: i64::try_from(local_ns).ok()?, ahead_s })
    }

    /// Whether its zone is written.
    pub(crate) fn is_zoned(self) -> bool {
        self.ahead_s.is_some()
    }

    /// Nanoseconds since 1970-01-01T00:00Z; `ahead_s` is the zone of a time without one. None out
    /// of range.
    pub(crate) fn utc_ns(self, ahead_s: i64) -> Option<i64> {
        self.local_ns.checked_sub(self.ahead_s.unwrap_or(ahead_s).checked_mul(NS as i64)?)
    }
}

/// Seconds by which a zone `Z`, `+01`, `+0100` or `+01:00` is ahead of UTC.
pub(crate) fn zone_s(text: &str) -> Option<i64> {
    if matches!(text, "Z" | "z") {
        return Some(0);
    }
    let sign = match text.as_bytes().first()? {
        b'+' => 1,
        b'-' => -1,
        _ => return None,
    };
    let digits = &text[1..];
    let (hours, minutes) = match digits.len() {
        2 => (digits, "0"),
        4 => digits.split_at_checked(2)?,
        5 => digits.split_once(':')?,
        _ => return None,
    };
    let (hours, minutes) = (below(hours, 24)?, below(minutes, 60)?);
    Some(sign * (3600 * hours + 60 * minutes))
}

/// A number of digits alone, below a limit.
fn below(digits: &str, limit: i64) -> Option<i64> {
    let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    if is_number { digits.parse().ok().filter(|number| *number < limit) } else { None }
}

/// The parts of `aa:bb:cc` or `aabbcc`, the first of `width` digits and the others of two.
fn parts(text: &str, sign: char, width: usize) -> Option<Vec<&str>> {
    if !text.is_ascii() {
        return None;
    }
    let parts: Vec<&str> = if text.contains(sign) {
        text.split(sign).collect()
    } else {
        let (first, mut rest) = text.split_at_checked(width)?;
        let mut parts = vec![first];
        while !rest.is_empty() {
            let (part, after) = rest.split_at_checked(2)?;
            parts.push(part);
            rest = after;
        }
        parts
    };
    let wide = |(place, part): (usize, &&str)| part.len() == if place == 0 { width } else { 2 };
    parts.iter().enumerate().all(wide).then_some(parts)
}

/// Days from 1970-01-01 to a date of the Gregorian calendar.
fn date_days(text: &str) -> Option<i64> {
    let parts = parts(text, '-', 4)?;
    let [year, month, day] = parts[..] else { return None };
    let (year, month, day) = (below(year, 10_000)?, below(month, 13)?, below(day, 32)?);
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let lengths = [31, if is_leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    if month == 0 || day == 0 || day > lengths[month as usize - 1] {
        return None;
    }
    // Proleptic Gregorian calendar, counted from 0001-01-01.
    let past_years = year - 1;
    let year_days = 365 * past_years + past_years / 4 - past_years / 100 + past_years / 400;
    let month_days: i64 = lengths[..month as usize - 1].iter().sum();
    // 719,162 days lie between 0001-01-01 and 1970-01-01.
    Some(year_days + month_days + day - 1 - 719_162)
}

/// Nanoseconds since midnight of a time of day with a colon: `9:59:59.600`, `21:05`, `9:05:00 PM`.
pub(crate) fn time_of_day_ns(text: &str) -> Option<i64> {
    const NOON_NS: i64 = 43_200 * NS as i64;
    let text = text.trim();
    let half = text.get(text.len().saturating_sub(2)..).unwrap_or_default().to_ascii_uppercase();
    let is_halved = half == "AM" || half == "PM";
    let clock = if is_halved { text[..text.len() - 2].trim_end() } else { text };
    // Hours before ten may have one digit.
    let hours = clock.find(':')?;
    let ns = if hours == 1 { clock_ns(&format!("0{clock}"))? } else { clock_ns(clock)? };
    match half.as_str() {
        _ if !is_halved => Some(ns),
        // 12 AM is midnight, 12 PM is noon.
        _ if !(1..=12).contains(&(clock[..hours].parse::<i64>().ok()?)) => None,
        "PM" => Some(ns % NOON_NS + NOON_NS),
        _ => Some(ns % NOON_NS),
    }
}

/// Nanoseconds since midnight of a time of day with or without a fraction of a second.
fn clock_ns(time: &str) -> Option<i64> {
    let (clock, fraction) = time.split_once(['.', ',']).unwrap_or((time, ""));
    let seconds = clock_s(clock)?;
    // A fraction follows seconds, and a decimal sign is followed by one.
    let has_seconds = clock.len() == 8 || clock.len() == 6;
    if clock.len() < time.len() && (fraction.is_empty() || !has_seconds) {
        return None;
    }
    Some(seconds * NS as i64 + fraction_ns(fraction)?)
}

/// Seconds since midnight of `hh:mm`, `hh:mm:ss`, `hhmm` or `hhmmss`; a second may be a leap
/// second.
fn clock_s(text: &str) -> Option<i64> {
    let parts = parts(text, ':', 2)?;
    let (hours, minutes, seconds) = match parts[..] {
        [hours, minutes] => (hours, minutes, "0"),
        [hours, minutes, seconds] => (hours, minutes, seconds),
        _ => return None,
    };
    Some(3600 * below(hours, 24)? + 60 * below(minutes, 60)? + below(seconds, 61)?)
}

/// Nanoseconds of a decimal fraction; digits beyond them are cut off.
fn fraction_ns(digits: &str) -> Option<i64> {
    if !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let nine_digits: String =
        digits.chars().chain(std::iter::repeat('0')).take(FRACTION_DIGITS).collect();
    nine_digits.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_the_calendar() {
        let utc = |text: &str| IsoTime::parse(text).and_then(|time| time.utc_ns(0));
        let exact = Some(1_709_288_130_123_456_789);
        for same in [
            "2024-03-01T10:15:30.123456789Z",
            "2024-03-01 10:15:30,123456789",
            "20240301T101530.1234567891+00",
            "2024-03-01T11:15:30.123456789+01:00",
            "2024-03-01 04:45:30.123456789 -0530",
        ] {
            assert_eq!(utc(same), exact, "{same}");
        }
        assert_eq!((utc("1970-01-01T00:00"), utc("1969-12-31T23:59:60")), (Some(0), Some(0)));
        assert_eq!(utc("2000-02-29t00:00:00z"), Some(951_782_400 * 1_000_000_000));
        assert_eq!(utc("1900-03-01T00:00:00"), Some(-2_203_891_200 * 1_000_000_000));
        let zoned = |text| IsoTime::parse(text).map(IsoTime::is_zoned);
        assert_eq!(
            (zoned("2024-03-01T10:15:30Z"), zoned("2024-03-01T10:15:30")),
            (Some(true), Some(false))
        );
        assert_eq!(
            IsoTime::parse("2024-03-01T10:15:30").unwrap().utc_ns(3600),
            Some(1_709_284_530_000_000_000)
        );
    }

    #[test]
    fn times_of_day_have_two_writings() {
        let ns = |seconds: f64| Some((seconds * 1e9).round() as i64);
        for (text, seconds) in [
            ("09:59:59.600", 35_999.6),
            ("9:59:59,6", 35_999.6),
            ("00:00", 0.0),
            ("12:00:01 AM", 1.0),
            ("12:30:00 pm", 45_000.0),
            ("9:05:00.5PM", 75_900.5),
        ] {
            assert_eq!(time_of_day_ns(text), ns(seconds), "{text}");
        }
        for bad in ["", "9", "095959", "25:00:00", "13:00:00 PM", "0:10:00 AM", "9:5:00", "PM"] {
            assert_eq!(time_of_day_ns(bad), None, "{bad}");
        }
    }

    #[test]
    fn what_is_no_date_with_a_time_is_refused() {
        for bad in [
            "",
            "T",
            "2024-03-01",
            "10:15:30",
            "2024-02-30T10:00",
            "2023-02-29T10:00",
            "2024-13-01T10:00",
            "2024-03-01T24:00",
            "2024-03-01T10:60",
            "2024-03-01T10",
            "2024-03-01T10:15.5",
            "2024-03-01T10:15:30.",
            "2024-03-01T10:15:30+1",
            "2024-03-01T10:15:30+01:75",
            "2024-3-1T10:15",
            "9999-01-01T00:00",
            "1.5 s",
            "2024-03-01T10:15:30 Europe/Berlin",
            "20２4-03-01T10:15",
        ] {
            assert_eq!(IsoTime::parse(bad).and_then(|time| time.utc_ns(0)), None, "{bad}");
        }
    }
}
