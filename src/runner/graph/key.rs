//! Content keys: what a stage's result is filed under.

use super::digest::Digest;
use serde::Serialize;

/// The digest of everything that a stage's result depends on.
pub type Key = Digest;

/// The key of a stage: its name, its code, the spec parts that it reads and the keys of its inputs.
///
/// # Errors
/// The serialiser's words when `params` is no JSON (a map with keys that are no text).
pub(crate) fn key(
    stage: &str,
    code: &Digest,
    params: &impl Serialize,
    inputs: &[Key],
) -> Result<Key, String> {
    let params = serde_json::to_vec(params).map_err(|error| error.to_string())?;
    let mut hasher = blake3::Hasher::new();
    // Each part goes with its length: other parts that join to the same bytes have another key.
    for part in [b"spinebench stage".as_slice(), stage.as_bytes(), code.bytes(), &params] {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    for input in inputs {
        hasher.update(input.bytes());
    }
    Ok(hasher.finalize().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_counts() {
        let key = |stage, code: &str, params: &str, inputs: &[Key]| {
            key(stage, &Digest::of(code.as_bytes()), &params, inputs).unwrap()
        };
        let base = key("a", "1", "p", &[]);
        assert_eq!(base, key("a", "1", "p", &[]));
        for other in [
            key("b", "1", "p", &[]),
            key("a", "2", "p", &[]),
            key("a", "1", "q", &[]),
            key("a", "1", "p", &[base]),
        ] {
            assert_ne!(base, other);
        }
        assert_eq!(Digest::parse(&base.to_string()), Some(base));
        assert_eq!((base.to_string().len(), Digest::parse("rubbish")), (64, None));
    }
}
