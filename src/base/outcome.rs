//! What became of a trial, a run or a lap.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// What became of a trial: `ok`, or the named failure, as which it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It ended without a failure.
    Ok,
    /// Why there is no result.
    Failed(String),
}

impl Outcome {
    /// Whether it ended without a failure.
    pub fn is_ok(&self) -> bool {
        *self == Outcome::Ok
    }

    /// As it stands in tables.
    pub fn as_str(&self) -> &str {
        match self {
            Outcome::Ok => "ok",
            Outcome::Failed(reason) => reason,
        }
    }
}

impl From<String> for Outcome {
    fn from(text: String) -> Outcome {
        if text == Outcome::Ok.as_str() { Outcome::Ok } else { Outcome::Failed(text) }
    }
}

impl<T, E: Display> From<&Result<T, E>> for Outcome {
    fn from(result: &Result<T, E>) -> Outcome {
        result.as_ref().map_or_else(|error| Outcome::Failed(error.to_string()), |_| Outcome::Ok)
    }
}

impl Display for Outcome {
    fn fmt(&self, formatter: &mut Formatter) -> fmt::Result {
        formatter.write_str(self.as_str())
    }
}

impl Serialize for Outcome {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for Outcome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Outcome, D::Error> {
        String::deserialize(deserializer).map(Outcome::from)
    }
}
