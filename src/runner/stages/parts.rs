//! The parts of a spec that many stages read: shared by their jobs, and in the stages' keys as one digest each, so that
//! a sweep of many points neither copies nor writes out a robot for every stage.

use crate::policies::PolicyOptions;
use crate::runner::digest::Digest;
use crate::specs::{Experiment, PlantSpec};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::Arc;

/// A part of a spec with the digest of its JSON, which is how it serialises.
pub(super) struct Part<T>(Arc<(T, String)>);

impl<T: Serialize + PartialEq> Part<T> {
    /// `value`, in the same memory as `before` where the two are equal.
    fn of(value: T, before: Option<&Part<T>>) -> Result<Part<T>, String> {
        if let Some(same) = before.filter(|before| before.0.0 == value) {
            return Ok(same.clone());
        }
        let json = serde_json::to_vec(&value).map_err(|error| error.to_string())?;
        Ok(Part(Arc::new((value, Digest::of(&json).to_string()))))
    }
}

impl Part<PlantSpec> {
    /// A robot: of one that replays a recording the content counts as well.
    fn robot(value: PlantSpec, before: Option<&Part<PlantSpec>>) -> Result<Part<PlantSpec>, String> {
        let PlantSpec::Replay(options) = &value else { return Part::of(value, before) };
        let mut bytes = serde_json::to_vec(&value).map_err(|error| error.to_string())?;
        // A recording that cannot be read fails the stages that ask for it.
        bytes.extend(std::fs::read(&options.recording).unwrap_or_default());
        Ok(Part(Arc::new((value, Digest::of(&bytes).to_string()))))
    }
}

impl<T> Clone for Part<T> {
    fn clone(&self) -> Self {
        Part(self.0.clone())
    }
}

impl<T> Deref for Part<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0.0
    }
}

impl<T> Serialize for Part<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0.1)
    }
}

/// The shared parts of one experiment.
pub(in crate::runner) struct Parts {
    pub(super) model: Part<PlantSpec>,
    pub(super) plant: Part<PlantSpec>,
    /// The robot measured without noise.
    pub(super) quiet: Part<PlantSpec>,
    /// The robot in each mode, with the mode's effects.
    pub(super) modes: BTreeMap<String, Part<PlantSpec>>,
    pub(super) policies: Part<PolicyOptions>,
}

impl Parts {
    /// The parts of `spec`; those that equal the ones of the experiment `before` are shared with it.
    ///
    /// # Errors
    /// The serialiser's words for a part that is no JSON.
    pub(in crate::runner) fn new(spec: &Experiment, before: Option<&Parts>) -> Result<Parts, String> {
        let mode = |(name, mode): (&String, &crate::specs::Mode)| {
            let before = before.and_then(|before| before.modes.get(name));
            Part::robot(spec.plant.with_effects(&mode.effects), before).map(|plant| (name.clone(), plant))
        };
        Ok(Parts {
            model: Part::robot(spec.model.clone(), before.map(|before| &before.model))?,
            plant: Part::robot(spec.plant.clone(), before.map(|before| &before.plant))?,
            quiet: Part::robot(spec.plant.without_noise(), before.map(|before| &before.quiet))?,
            modes: spec.modes.iter().map(mode).collect::<Result<_, String>>()?,
            policies: Part::of(spec.policies, before.map(|before| &before.policies))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plants::ReplayOptions;

    #[test]
    fn another_recording_under_the_same_name_is_another_robot() {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("rec.csv");
        let digest = |text: &str| {
            std::fs::write(&recording, text).unwrap();
            let options = ReplayOptions { recording: recording.clone(), tolerance_m: 1e-6, tendons: 4 };
            Part::robot(PlantSpec::Replay(options), None).unwrap().0.1.clone()
        };
        assert_eq!(digest("a"), digest("a"));
        assert_ne!(digest("a"), digest("b"));
    }
}
