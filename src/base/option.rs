//! Range checks of settings.

use std::ops::RangeBounds;

/// A setting out of range; the specs add file and line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key}: found {found}, expected {expected}")]
pub struct BadOption {
    /// Name of the field.
    pub key: &'static str,
    /// Its value.
    pub found: String,
    /// The expected range.
    pub expected: &'static str,
}

impl BadOption {
    /// Error unless `good`.
    pub fn unless(
        good: bool,
        key: &'static str,
        found: impl ToString,
        expected: &'static str,
    ) -> Result<(), BadOption> {
        if good { Ok(()) } else { Err(BadOption { key, found: found.to_string(), expected }) }
    }

    /// Error unless `value` lies in `range`.
    pub fn unless_within<T: PartialOrd + ToString>(
        key: &'static str,
        value: T,
        range: impl RangeBounds<T>,
        expected: &'static str,
    ) -> Result<(), BadOption> {
        Self::unless(range.contains(&value), key, value, expected)
    }

    /// Error unless all `values` are finite.
    pub fn unless_all_finite(key: &'static str, values: &[f64]) -> Result<(), BadOption> {
        values.iter().try_for_each(|&value| Self::unless_finite(key, value))
    }

    /// Error unless `value` is finite.
    pub fn unless_finite(key: &'static str, value: f64) -> Result<(), BadOption> {
        Self::unless(value.is_finite(), key, value, "a finite number")
    }

    /// Error unless `value` is finite and at least zero.
    pub fn unless_not_negative(key: &'static str, value: f64) -> Result<(), BadOption> {
        Self::unless(value.is_finite() && value >= 0.0, key, value, "a finite number of at least 0")
    }

    /// Error unless `value` is finite and above zero.
    pub fn unless_positive(key: &'static str, value: f64) -> Result<(), BadOption> {
        Self::unless(value.is_finite() && value > 0.0, key, value, "a finite number above 0")
    }

    /// Error unless `value` is absent or finite and above zero.
    pub fn unless_positive_or_null(key: &'static str, value: Option<f64>) -> Result<(), BadOption> {
        value.map_or(Ok(()), |number| Self::unless_positive(key, number))
    }

    /// Error unless `value` is above 0 and at most 1.
    pub fn unless_share(key: &'static str, value: f64) -> Result<(), BadOption> {
        Self::unless(value > 0.0 && value <= 1.0, key, value, "a number above 0 and at most 1")
    }

    /// Error unless `value` is at least 1.
    pub fn unless_counted(key: &'static str, value: usize) -> Result<(), BadOption> {
        Self::unless(value > 0, key, value, "a whole number of at least 1")
    }
}
