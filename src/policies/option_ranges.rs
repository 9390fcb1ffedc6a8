//! Range checks that several policies share.

use crate::base::BadOption;

/// Error unless `value` is above 0 and at most 1.
pub(super) fn unless_share(key: &'static str, value: f64) -> Result<(), BadOption> {
    if value > 0.0 && value <= 1.0 {
        return Ok(());
    }
    Err(BadOption { key, found: value.to_string(), expected: "a number above 0 and at most 1" })
}
