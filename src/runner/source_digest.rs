//! What the code of a stage is: a digest of the sources and packages that its numbers come from. It is part of the
//! stage's key, so that a result of other code is never taken for one of this code.

use super::digest::Digest;

include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// Sources of a kind of stage: what the path of a source below `src/` begins with. A trailing `!` leaves out.
pub(super) type Sources = &'static [&'static str];

/// How a robot is made of its spec.
const SPEC: &str = "specs/experiment/plant.rs";
/// How results are laid out in the store.
const CODEC: &str = "runner/codec/";
const STAGES: &str = "runner/stages/";

/// Whatever moves: the rod, its effects, simulated robots, the loops.
pub(super) const ROBOT: Sources = &[
    "base/",
    "math/",
    "data/",
    "rod/",
    "effects/",
    "plants/",
    "plants/hardware/!",
    "tasks/",
    "benchmark/",
    SPEC,
    CODEC,
    STAGES,
];
/// Whatever learns.
pub(super) const LEARN: Sources = &["base/", "math/", "learn/", "policies/", "tasks/", "runner/stages/"];
/// Policies on robots.
pub(super) const TRIAL: Sources = &[
    "base/",
    "math/",
    "data/",
    "rod/",
    "effects/",
    "plants/",
    "plants/hardware/!",
    "learn/",
    "policies/",
    "tasks/",
    SPEC,
    CODEC,
    STAGES,
];
/// Whatever looks for what a model lacks.
pub(super) const DISCOVERY: Sources = &[
    "base/",
    "math/",
    "data/",
    "rod/",
    "effects/",
    "learn/",
    "discovery/",
    "tasks/",
    "benchmark/",
    SPEC,
    CODEC,
    STAGES,
];
/// Robots on a bench and rehearsals of them; part of the digest of such a robot, not of all stages.
pub(super) const BENCH: Sources = &["plants/hardware/", "hardware/", "simulators/"];

/// The digest of the code that `sources` name, and of the packages.
pub(super) fn digest(sources: Sources) -> Digest {
    let (out, within): (Vec<&str>, Vec<&str>) = sources.iter().partition(|source| source.ends_with('!'));
    let counts = |name: &str| {
        let below = |folder: &&str| name.starts_with(folder.trim_end_matches('!'));
        name == "packages" || (within.iter().any(below) && !out.iter().any(below))
    };
    let mut hasher = blake3::Hasher::new();
    for (name, code) in SOURCES.iter().filter(|(name, _)| counts(name)) {
        hasher.update(name.as_bytes());
        for half in code {
            hasher.update(&half.to_le_bytes());
        }
    }
    Digest::from(hasher.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_folder_of_sources_and_the_digests_differ() {
        let all = [ROBOT, LEARN, TRIAL, DISCOVERY, BENCH];
        for folder in all.iter().flat_map(|sources| sources.iter()) {
            let folder = folder.trim_end_matches('!');
            assert!(SOURCES.iter().any(|(name, _)| name.starts_with(folder)), "{folder}");
        }
        let digests: std::collections::BTreeSet<Digest> = all.iter().map(|sources| digest(sources)).collect();
        assert_eq!(digests.len(), all.len());
        assert_eq!(digest(&[]), digest(&["no such folder"]), "packages always count");
    }
}
