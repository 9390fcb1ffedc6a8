//! The seed tree: each part of an experiment draws from its own stream, named by its path. Adding a
//! part or a thread changes no other part.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The random number generator of the crate.
pub type Generator = ChaCha8Rng;

/// A node of the seed tree. ChaCha8 streams are documented as portable across machines and
/// versions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Seed(pub u64);

impl Seed {
    /// The seed of the part called `name` below this one (FNV-1a over the name, SplitMix64
    /// finaliser).
    pub fn child(self, name: &str) -> Seed {
        let hash = name.bytes().fold(self.0 ^ 0xcbf2_9ce4_8422_2325, |h, b| {
            (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        Seed(finalise(hash))
    }

    /// The seed of the part number `index` below this one.
    pub fn index(self, index: u64) -> Seed {
        Seed(finalise(self.0 ^ finalise(index.wrapping_add(1))))
    }

    /// A generator that starts at this node.
    pub fn rng(self) -> Generator {
        Generator::seed_from_u64(self.0)
    }
}

fn finalise(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn siblings_differ_and_paths_repeat() {
        let root = Seed(7);
        assert_ne!(root.child("collect"), root.child("train"));
        assert_ne!(root.index(0), root.index(1));
        assert_ne!(root.child("a").child("b"), root.child("b").child("a"));
        assert_eq!(root.child("collect").index(3), root.child("collect").index(3));
    }
}
