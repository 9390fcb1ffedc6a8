//! The parts of a spec that many stages read: shared by their jobs, and in the stages' keys as one digest each, so that
//! a sweep of many points neither copies nor writes out a robot for every stage.

use super::identified::Identified;
use crate::policies::PolicyOptions;
use crate::runner::digest::Digest;
use crate::runner::graph::Failure;
use crate::specs::{Experiment, PlantSpec};
use serde::{Serialize, Serializer};
use std::ops::Deref;
use std::sync::Arc;

/// A part of a spec with the digest of its JSON, which is how it serialises.
pub(super) struct Part<T>(Arc<(T, Digest)>);

impl<T: Serialize> Part<T> {
    fn new(value: T) -> Result<Part<T>, Failure> {
        let failed = |error: serde_json::Error| Failure { stage: "spec".into(), status: error.to_string() };
        let json = serde_json::to_vec(&value).map_err(failed)?;
        Ok(Part(Arc::new((value, Digest::of(&json)))))
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
        self.0.1.serialize(serializer)
    }
}

/// The shared parts of one experiment.
pub(in crate::runner) struct Parts {
    pub(super) model: Identified,
    pub(super) plant: Identified,
    /// The robot measured without noise.
    pub(super) quiet: Identified,
    pub(super) policies: Part<PolicyOptions>,
}

impl Parts {
    /// The parts of `spec`; robots that equal those of the experiment `before` are shared with it.
    ///
    /// # Errors
    /// [`Failure`] for a part that cannot be written into a key.
    pub(in crate::runner) fn new(spec: &Experiment, before: Option<&Parts>) -> Result<Parts, Failure> {
        let robot = |spec: PlantSpec, before: Option<&Identified>| match before.filter(|before| before.is(&spec)) {
            Some(same) => Ok(same.clone()),
            None => Identified::new(spec),
        };
        Ok(Parts {
            model: robot(spec.model.clone(), before.map(|before| &before.model))?,
            plant: robot(spec.plant.clone(), before.map(|before| &before.plant))?,
            quiet: robot(spec.plant.without_noise(), before.map(|before| &before.quiet))?,
            policies: Part::new(spec.policies)?,
        })
    }
}
