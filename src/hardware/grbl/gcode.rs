//! Composes G-code for a move, or refuses it: the last check before the serial line.

use super::fault::MoveRefusal;
use super::settings::MotionSettings;

/// Real-time byte: pause motion (feed hold).
pub(super) const HOLD: u8 = b'!';
/// Real-time byte: resume motion (cycle start).
pub(super) const RESUME: u8 = b'~';
/// Real-time byte: soft reset (Ctrl-X).
pub(super) const RESET: u8 = 0x18;
/// Real-time byte: a status report with everything that grblHAL can report.
pub(super) const FULL_REPORT: u8 = 0x87;

/// Slowest feed that is sent, mm/min.
const MIN_FEED_MM_MIN: f64 = 0.1;

/// A move that passed all checks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Move {
    /// Target after rounding, mm.
    pub(crate) target_mm: [f64; 4],
    /// The G-code line.
    pub(crate) line: String,
}

/// Composes a move to `target_mm` at `feed_mm_min`; the checks apply to the values after rounding.
pub(crate) fn compose(
    target_mm: [f64; 4],
    feed_mm_min: f64,
    settings: &MotionSettings,
) -> Result<Move, MoveRefusal> {
    if !(feed_mm_min.is_finite() && target_mm.iter().all(|value| value.is_finite())) {
        return Err(MoveRefusal::NotFinite);
    }
    // The checks must see what the line says: three decimals.
    let target_mm = target_mm.map(|value| rounded(value, 1e3));
    for (axis, target_mm) in target_mm.into_iter().enumerate() {
        let (low_mm, high_mm) = settings.limits_mm(axis);
        if target_mm < low_mm || target_mm > high_mm {
            return Err(MoveRefusal::OutsideTravel { axis, target_mm, low_mm, high_mm });
        }
    }
    let most_mm_min = settings.max_speed_mm_min;
    let feed_mm_min = rounded(feed_mm_min, 10.0);
    if feed_mm_min < MIN_FEED_MM_MIN || feed_mm_min > most_mm_min {
        return Err(MoveRefusal::Feed { feed_mm_min, most_mm_min });
    }
    let [x, y, z, a] = target_mm;
    Ok(Move { target_mm, line: format!("G1 X{x:.3} Y{y:.3} Z{z:.3} A{a:.3} F{feed_mm_min:.1}") })
}

/// Rounds to `1 / parts`, without a negative zero.
fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts + 0.0
}
