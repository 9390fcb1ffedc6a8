//! What a cell of a table must hold for its row to count.

use std::borrow::Cow;
use std::fmt;

use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};

/// A text, or a number however it is written.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct CellMatch(String);

impl CellMatch {
    /// Whether a cell holds it.
    pub(crate) fn is_in(&self, cell: &str) -> bool {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        cell.trim() == self.0.trim()
            || number(cell).is_some_and(|cell| number(&self.0) == Some(cell))
    }
}

impl fmt::Display for CellMatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}`", self.0)
    }
}

impl<'de> Deserialize<'de> for CellMatch {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<CellMatch, D::Error> {
        struct Scalar;
        impl Visitor<'_> for Scalar {
            type Value = CellMatch;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the text or number in a cell")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<CellMatch, E> {
                Ok(CellMatch(text.to_owned()))
            }

            fn visit_bool<E: de::Error>(self, flag: bool) -> Result<CellMatch, E> {
                Ok(CellMatch(flag.to_string()))
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<CellMatch, E> {
                Ok(CellMatch(number.to_string()))
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<CellMatch, E> {
                Ok(CellMatch(number.to_string()))
            }

            fn visit_f64<E: de::Error>(self, number: f64) -> Result<CellMatch, E> {
                Ok(CellMatch(number.to_string()))
            }
        }
        deserializer.deserialize_any(Scalar)
    }
}

impl schemars::JsonSchema for CellMatch {
    fn schema_name() -> Cow<'static, str> {
        "CellMatch".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "The text or number in a cell.",
            "type": ["string", "number", "boolean"],
        })
    }
}
