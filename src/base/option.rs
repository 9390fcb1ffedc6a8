//! Range checks of settings.

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
    /// Error unless `value` is finite and above zero.
    pub fn unless_positive(key: &'static str, value: f64) -> Result<(), BadOption> {
        if value.is_finite() && value > 0.0 {
            return Ok(());
        }
        Err(BadOption { key, found: value.to_string(), expected: "a finite number above 0" })
    }

    /// Error unless `value` is absent or finite and above zero.
    pub fn unless_positive_or_null(key: &'static str, value: Option<f64>) -> Result<(), BadOption> {
        value.map_or(Ok(()), |number| Self::unless_positive(key, number))
    }

    /// Error unless `value` is at least 1.
    pub fn unless_counted(key: &'static str, value: usize) -> Result<(), BadOption> {
        if value > 0 {
            return Ok(());
        }
        Err(BadOption { key, found: value.to_string(), expected: "a whole number of at least 1" })
    }
}
