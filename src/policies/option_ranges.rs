//! Range checks that several policies share.

use crate::base::BadOption;

/// Error unless `value` is above 0 and at most 1.
pub(super) fn unless_share(key: &'static str, value: f64) -> Result<(), BadOption> {
    if value > 0.0 && value <= 1.0 {
        return Ok(());
    }
    Err(BadOption { key, found: value.to_string(), expected: "a number above 0 and at most 1" })
}

/// Error unless `value` is finite and at least 0.
pub(super) fn unless_not_negative(key: &'static str, value: f64) -> Result<(), BadOption> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(BadOption { key, found: value.to_string(), expected: "a finite number of at least 0" })
}

/// Error unless `value` is from 1 to `most`, which `expected` says in words.
pub(super) fn unless_count_to(
    key: &'static str,
    value: usize,
    most: usize,
    expected: &'static str,
) -> Result<(), BadOption> {
    if (1..=most).contains(&value) {
        return Ok(());
    }
    Err(BadOption { key, found: value.to_string(), expected })
}
