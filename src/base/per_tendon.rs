//! A number that holds for all tendons, or a list with one for each.

use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{self, Deserializer, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

/// One number for all tendons, or one for each.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
#[serde(untagged)]
pub enum PerTendon {
    /// The same for all.
    Same(f64),
    /// One for each.
    Each(Vec<f64>),
}

impl Default for PerTendon {
    fn default() -> Self {
        PerTendon::Same(0.0)
    }
}

impl From<f64> for PerTendon {
    fn from(value: f64) -> Self {
        PerTendon::Same(value)
    }
}

impl PerTendon {
    /// The number of tendon `tendon`, from 0.
    pub fn of(&self, tendon: usize) -> f64 {
        match self {
            PerTendon::Same(value) => *value,
            PerTendon::Each(values) => values[tendon],
        }
    }

    /// All numbers.
    pub fn values(&self) -> &[f64] {
        match self {
            PerTendon::Same(value) => std::slice::from_ref(value),
            PerTendon::Each(values) => values,
        }
    }

    /// Whether it has a number for each of `count` tendons.
    pub fn fits(&self, count: usize) -> bool {
        match self {
            PerTendon::Same(_) => true,
            PerTendon::Each(values) => values.len() == count,
        }
    }
}

impl<'de> Deserialize<'de> for PerTendon {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrList;

        impl<'de> Visitor<'de> for NumberOrList {
            type Value = PerTendon;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, or a list of one number per tendon")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<PerTendon, E> {
                Ok(PerTendon::Same(value))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<PerTendon, E> {
                Ok(PerTendon::Same(value as f64))
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<PerTendon, E> {
                Ok(PerTendon::Same(value as f64))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<PerTendon, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(list)).map(PerTendon::Each)
            }
        }

        deserializer.deserialize_any(NumberOrList)
    }
}
