//! Numbers as people read them.

use crate::report::drawing::{signed, text_width};

/// What stands for a number that is not there.
pub(crate) const NONE: &str = "–";

/// A number with `digits` significant digits, at most six decimals, and a typographer's minus.
pub(crate) fn number(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    signed(value, decimals(value, digits))
}

/// Decimals that show `digits` significant digits of `value`.
pub(crate) fn decimals(value: f64, digits: i32) -> usize {
    let size = value.abs();
    let power = if size > 0.0 && size.is_finite() { size.log10().floor() } else { 0.0 };
    (f64::from(digits) - 1.0 - power).clamp(0.0, 6.0) as usize
}

/// A length in metres as millimetres with their unit, on one line.
pub(crate) fn millimetres(value_m: f64) -> String {
    if value_m.is_finite() {
        format!("{}\u{a0}mm", number(1e3 * value_m, 3))
    } else {
        NONE.to_owned()
    }
}

/// How many times the noise floor a size is.
pub(crate) fn times(size_m: f64, floor_m: f64) -> String {
    let ratio = size_m / floor_m;
    if ratio.is_finite() { format!("{}\u{a0}×", ratio_text(ratio)) } else { NONE.to_owned() }
}

/// A ratio with one decimal below ten.
pub(crate) fn ratio_text(ratio: f64) -> String {
    match ratio {
        _ if !ratio.is_finite() => NONE.to_owned(),
        // From here on a number rounds to one digit more.
        ratio if ratio < 9.95 => signed(ratio, 1),
        ratio if ratio < 999.5 => signed(ratio, 0),
        _ => ">999".to_owned(),
    }
}

/// A share as a percentage; what is not quite everything is not called so.
pub(crate) fn percent(share: f64) -> String {
    match 100.0 * share {
        value if !value.is_finite() => NONE.to_owned(),
        value if value < 100.0 && value > 99.0 => {
            format!("{} %", signed((10.0 * value).floor() / 10.0, 1))
        }
        value => format!("{} %", signed(value, 0)),
    }
}

/// A probability.
pub(crate) fn probability(p: f64) -> String {
    match p {
        _ if !p.is_finite() => NONE.to_owned(),
        p if p < 0.001 => "< 0.001".to_owned(),
        p => signed(p, 3),
    }
}

/// Names in a sentence: `a`, `a and b`, `a, b and c`.
pub(crate) fn enumerate(names: &[String], last: &str) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

/// The text on one line, cut with an ellipsis where it would be wider than `room`.
pub(crate) fn fitted(words: &str, size: f64, room: f64) -> String {
    let clean: String =
        words.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
    if text_width(&clean, size, false) <= room {
        return clean;
    }
    let mut letters: Vec<char> = clean.chars().take(400).collect();
    while letters.pop().is_some() {
        let short: String = letters.iter().collect::<String>().trim_end().to_owned() + "…";
        if text_width(&short, size, false) <= room {
            return short;
        }
    }
    String::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_honest() {
        assert_eq!(number(0.019_73, 3), "0.0197");
        assert_eq!(number(-1234.5, 3), "−1234");
        assert_eq!(number(0.0, 3), "0.00");
        assert_eq!(number(f64::NAN, 3), "–");
        assert_eq!(millimetres(0.0121), "12.1\u{a0}mm");
        assert_eq!(percent(0.9999), "99.9 %");
        assert_eq!(percent(1.0), "100 %");
        assert_eq!(percent(-0.07), "−7 %");
        assert_eq!(probability(1e-9), "< 0.001");
        assert_eq!(times(0.0121, 0.00087), "14\u{a0}×");
        assert_eq!(times(1.0, 0.0), "–");
    }

    #[test]
    fn long_names_are_cut_to_their_room() {
        let short = fitted(&"weighty ".repeat(500), 9.8, 80.0);
        assert!(short.ends_with('…') && text_width(&short, 9.8, false) <= 80.0);
        assert_eq!(fitted("x", 9.8, 80.0), "x");
        assert_eq!(fitted("long", 9.8, 0.5), "");
    }

    #[test]
    fn names_stand_in_a_sentence() {
        let names = ["a", "b", "c"].map(str::to_owned);
        assert_eq!(enumerate(&names, "or"), "a, b or c");
        assert_eq!(enumerate(&names[..1], "or"), "a");
        assert_eq!(enumerate(&[], "or"), "");
    }
}
