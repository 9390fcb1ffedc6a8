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
            Part::of(spec.plant.with_effects(&mode.effects), before).map(|plant| (name.clone(), plant))
        };
        Ok(Parts {
            model: Part::of(spec.model.clone(), before.map(|before| &before.model))?,
            plant: Part::of(spec.plant.clone(), before.map(|before| &before.plant))?,
            quiet: Part::of(spec.plant.without_noise(), before.map(|before| &before.quiet))?,
            modes: spec.modes.iter().map(mode).collect::<Result<_, String>>()?,
            policies: Part::of(spec.policies, before.map(|before| &before.policies))?,
        })
    }
}
