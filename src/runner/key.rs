//! Content keys: what a stage's result is filed under.

use serde::Serialize;
use std::fmt;

/// BLAKE3 of everything that a stage's result depends on.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key([u8; 32]);

impl Key {
    /// The key of a stage: its name, its code's version, the spec parts that it reads and the keys of its inputs.
    ///
    /// # Errors
    /// The serialiser's words when `params` is no JSON (a map with keys that are no text).
    pub fn new(stage: &str, version: u32, params: &impl Serialize, inputs: &[Key]) -> Result<Key, String> {
        let params = serde_json::to_vec(params).map_err(|error| error.to_string())?;
        let mut hasher = blake3::Hasher::new();
        for part in [b"spinebench stage".as_slice(), stage.as_bytes(), &version.to_le_bytes(), &params] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
        for input in inputs {
            hasher.update(&input.0);
        }
        Ok(Key(*hasher.finalize().as_bytes()))
    }

    /// The first 12 hexadecimal digits, enough for a person.
    pub fn short(&self) -> String {
        self.to_string()[..12].to_owned()
    }
}

impl fmt::Display for Key {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(out, "{byte:02x}"))
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.short())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_counts() {
        let key = |stage, version, params: &str, inputs: &[Key]| Key::new(stage, version, &params, inputs).unwrap();
        let base = key("a", 1, "p", &[]);
        assert_eq!(base, key("a", 1, "p", &[]));
        for other in [key("b", 1, "p", &[]), key("a", 2, "p", &[]), key("a", 1, "q", &[]), key("a", 1, "p", &[base])] {
            assert_ne!(base, other);
        }
        assert_eq!(base.to_string().len(), 64);
    }
}
