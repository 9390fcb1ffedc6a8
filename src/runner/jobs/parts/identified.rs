//! A robot of a spec beside the digest of all that it is: stages are filed under the digest, so
//! that a model need not be written out for each of a hundred thousand of them.

use crate::base::Plant;
use crate::effects::EffectSpec;
use crate::plants::{Changing, RobotChange};
use crate::runner::graph::digest::Digest;
use crate::runner::graph::failure::Failure;
use crate::runner::graph::source_digest;
use crate::specs::PlantSpec;
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// A robot and its digest. Written by serde as the digest.
#[derive(Clone)]
pub(crate) struct Identified {
    spec: Arc<PlantSpec>,
    digest: Digest,
}

impl Identified {
    /// Digests a robot; of one that replays a recording the content, wherever the file lies, and of
    /// a `hardware` plant the code that drives it.
    ///
    /// # Errors
    /// [`Failure`] for a robot that cannot be written as JSON.
    pub(crate) fn new(spec: PlantSpec) -> Result<Identified, Failure> {
        let failed =
            |error: serde_json::Error| Failure { stage: "plant".into(), status: error.to_string() };
        let mut bytes = serde_json::to_vec(&spec).map_err(failed)?;
        bytes.extend(spec.identity());
        if spec.drives_hardware() {
            bytes.extend(source_digest::of_bench().bytes());
        }
        Ok(Identified { digest: Digest::of(&bytes), spec: Arc::new(spec) })
    }

    /// True for a robot with the same settings.
    pub(crate) fn is(&self, spec: &PlantSpec) -> bool {
        *self.spec == *spec
    }

    /// Number of tendons.
    pub(crate) fn tendons(&self) -> usize {
        self.spec.tendons()
    }

    /// Its settings.
    pub(crate) fn spec(&self) -> &PlantSpec {
        &self.spec
    }

    /// The robot with further effects, moving in steps of `step_s` seconds.
    ///
    /// # Errors
    /// What is out of range or not as it should be, in words.
    pub(crate) fn build(
        &self,
        effects: &[EffectSpec],
        step_s: f64,
    ) -> Result<Box<dyn Plant>, String> {
        if effects.is_empty() {
            self.spec.build(step_s)
        } else {
            self.spec.with_effects(effects).build(step_s)
        }
    }

    /// The same robot, which changes during each trial where there is a change.
    ///
    /// # Errors
    /// As [`Identified::build`].
    pub(crate) fn build_changing(
        &self,
        effects: &[EffectSpec],
        change: Option<&RobotChange>,
        step_s: f64,
    ) -> Result<Box<dyn Plant>, String> {
        let before = self.build(effects, step_s)?;
        let Some(change) = change else { return Ok(before) };
        let after = self.build(&[effects, &change.effects].concat(), step_s)?;
        Ok(Box::new(Changing::new(before, after, change.between_s)))
    }
}

impl Serialize for Identified {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.digest.serialize(serializer)
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
            let options = ReplayOptions {
                recording: recording.clone(),
                tolerance_m: 1e-6,
                tendons: 4,
                drives: std::collections::BTreeMap::new(),
            };
            Identified::new(PlantSpec::Replay(Box::new(options))).unwrap().digest
        };
        assert_eq!(digest("a"), digest("a"));
        assert_ne!(digest("a"), digest("b"));
    }
}
