//! The bytes of stored results: `postcard`, which keeps every bit of a number.
//!
//! Text formats were not taken because what is read back must equal what was computed to the last
//! bit, NaN included. The form says nothing about itself: the code that a stage is filed under
//! tells which types wrote it.

use serde::{Serialize, de::DeserializeOwned};

/// Why bytes could not be written or read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum CodecError {
    /// Bytes are left over after the value.
    #[error("the stored value is followed by further bytes")]
    Surplus,
    /// The bytes are no value of the wanted type.
    #[error("the stored bytes are not of this type: {0}")]
    Malformed(String),
    /// The type has something that this form does not hold.
    #[error("this type cannot be stored: {0}")]
    Unsupported(String),
}

/// The bytes of `value`.
///
/// # Errors
/// [`CodecError::Unsupported`] for a sequence of unknown length.
pub(crate) fn encode<T: Serialize + ?Sized>(value: &T) -> Result<Vec<u8>, CodecError> {
    postcard::to_stdvec(value).map_err(|error| CodecError::Unsupported(error.to_string()))
}

/// The value that `bytes` hold.
///
/// # Errors
/// When the bytes are not exactly one value of this type.
pub(crate) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    let (value, rest) = postcard::take_from_bytes(bytes)
        .map_err(|error| CodecError::Malformed(error.to_string()))?;
    if rest.is_empty() { Ok(value) } else { Err(CodecError::Surplus) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use std::collections::BTreeMap;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    enum Choice {
        Nothing,
        One(f64),
        Pair(u8, i32),
        Named { a: Option<String>, b: [f64; 3] },
    }

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct All {
        numbers: Vec<f64>,
        choices: Vec<Choice>,
        map: BTreeMap<String, (bool, char)>,
        unit: (),
    }

    fn sample() -> All {
        All {
            numbers: vec![0.1, -0.0, f64::MIN_POSITIVE, 1e300],
            choices: vec![
                Choice::Nothing,
                Choice::One(2.0),
                Choice::Pair(7, -9),
                Choice::Named { a: Some("ä".into()), b: [1.0, 2.0, 3.0] },
                Choice::Named { a: None, b: [0.0; 3] },
            ],
            map: BTreeMap::from([("k".to_owned(), (true, 'ß'))]),
            unit: (),
        }
    }

    #[test]
    fn what_is_written_is_read_back_to_the_bit() {
        assert_eq!(decode::<All>(&encode(&sample()).unwrap()).unwrap(), sample());
        let nan = f64::from_bits(0x7ff8_0000_0000_0123);
        assert_eq!(decode::<f64>(&encode(&nan).unwrap()).unwrap().to_bits(), nan.to_bits());
    }

    #[test]
    fn every_truncation_and_any_surplus_is_an_error() {
        let bytes = encode(&sample()).unwrap();
        for length in 0..bytes.len() {
            assert!(decode::<All>(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
        }
        let longer = [bytes.as_slice(), &[0]].concat();
        assert_eq!(decode::<All>(&longer), Err(CodecError::Surplus));
    }
}
