//! Line and column of a key path in a YAML text.
//!
//! A deserialiser walks down the path and fails on purpose at its end; the parser adds the position
//! to the error. The position is therefore right in every style of YAML.

use super::path::{KeyPath, Step};
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// The part of a path's last step to locate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathEnd {
    /// The key itself.
    Key,
    /// The value under the key.
    Value,
}

/// Line and column (from 1) of `path` in `text`; `None` where the text has no such path.
pub fn locate(text: &str, path: &KeyPath, end: PathEnd) -> Option<(usize, usize)> {
    let seek = PathSeeker { steps: &path.0, end };
    let error = seek.deserialize(serde_yaml::Deserializer::from_str(text)).err()?;
    let found = error.to_string().contains(ARRIVED);
    error.location().filter(|_| found).map(|at| (at.line(), at.column()))
}

const ARRIVED: &str = "\u{1}arrived\u{1}";

#[derive(Clone, Copy)]
struct PathSeeker<'a> {
    steps: &'a [Step],
    end: PathEnd,
}

impl<'de> DeserializeSeed<'de> for PathSeeker<'_> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl PathSeeker<'_> {
    fn scalar<E: Error>(self) -> Result<(), E> {
        if self.steps.is_empty() { Err(E::custom(ARRIVED)) } else { Ok(()) }
    }
}

impl<'de> Visitor<'de> for PathSeeker<'_> {
    type Value = ();

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("anything")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Some((step, below)) = self.steps.split_first() else {
            return Err(A::Error::custom(ARRIVED));
        };
        let stop = below.is_empty() && self.end == PathEnd::Key;
        while let Some(matches) = map.next_key_seed(KeySeeker { step, stop })? {
            if matches {
                map.next_value_seed(PathSeeker { steps: below, end: self.end })?;
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let Some((step, below)) = self.steps.split_first() else {
            return Err(A::Error::custom(ARRIVED));
        };
        for index in 0.. {
            let more = if *step == Step::Item(index) {
                seq.next_element_seed(PathSeeker { steps: below, end: self.end })?.is_some()
            } else {
                seq.next_element::<IgnoredAny>()?.is_some()
            };
            if !more {
                break;
            }
        }
        Ok(())
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<(), E> {
        self.scalar()
    }
    fn visit_i64<E: Error>(self, _: i64) -> Result<(), E> {
        self.scalar()
    }
    fn visit_u64<E: Error>(self, _: u64) -> Result<(), E> {
        self.scalar()
    }
    fn visit_f64<E: Error>(self, _: f64) -> Result<(), E> {
        self.scalar()
    }
    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        self.scalar()
    }
    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.scalar()
    }
    fn visit_none<E: Error>(self) -> Result<(), E> {
        self.scalar()
    }
}

/// Compares a key with the wanted one, and fails on purpose when the path ends there.
struct KeySeeker<'a> {
    step: &'a Step,
    stop: bool,
}

impl<'de> DeserializeSeed<'de> for KeySeeker<'_> {
    type Value = bool;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<bool, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl<'de> Visitor<'de> for KeySeeker<'_> {
    type Value = bool;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("a key")
    }

    fn visit_str<E: Error>(self, key: &str) -> Result<bool, E> {
        let matches = matches!(self.step, Step::Key(wanted) if wanted == key);
        if matches && self.stop { Err(E::custom(ARRIVED)) } else { Ok(matches) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "# a comment\ngp:\n  sizes: [50,\n    100]\n  kernel: {se_ard: {starts: 3}}\nname: 'x'\n";

    fn at(path: &str, end: PathEnd) -> Option<(usize, usize)> {
        locate(TEXT, &KeyPath::parse(path).unwrap(), end)
    }

    #[test]
    fn keys_values_items_and_flow_style_are_found() {
        assert_eq!(at("gp", PathEnd::Key), Some((2, 1)));
        assert_eq!(at("gp.sizes", PathEnd::Value), Some((3, 10)));
        assert_eq!(at("gp.sizes[1]", PathEnd::Value), Some((4, 5)));
        assert_eq!(at("gp.kernel.se_ard.starts", PathEnd::Key), Some((5, 21)));
        assert_eq!(at("gp.kernel.se_ard.starts", PathEnd::Value), Some((5, 29)));
        assert_eq!(at("name", PathEnd::Value), Some((6, 7)));
        assert_eq!(at("gp.absent", PathEnd::Key), None);
        assert_eq!(at("name.absent", PathEnd::Key), None);
    }
}
