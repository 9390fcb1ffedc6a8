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
pub(super) struct SharedPart<T>(Arc<(T, Digest)>);

impl<T: Serialize> SharedPart<T> {
    fn new(value: T) -> Result<SharedPart<T>, Failure> {
        let failed = |error: serde_json::Error| Failure { stage: "spec".into(), status: error.to_string() };
        let json = serde_json::to_vec(&value).map_err(failed)?;
        Ok(SharedPart(Arc::new((value, Digest::of(&json)))))
    }
}

impl<T> Clone for SharedPart<T> {
    fn clone(&self) -> Self {
        SharedPart(self.0.clone())
    }
}

impl<T> Deref for SharedPart<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0.0
    }
}

impl<T> Serialize for SharedPart<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.1.serialize(serializer)
    }
}

/// The shared parts of one experiment.
pub(in crate::runner) struct SharedParts {
    pub(super) model: Identified,
    pub(super) plant: Identified,
    /// The robot measured without noise.
    pub(super) quiet: Identified,
    pub(super) policies: SharedPart<PolicyOptions>,
}

impl SharedParts {
    /// The parts of `spec`; robots that equal those of the experiment `before` are shared with it.
    ///
    /// # Errors
    /// [`Failure`] for a part that cannot be written into a key.
    pub(in crate::runner) fn new(spec: &Experiment, before: Option<&SharedParts>) -> Result<SharedParts, Failure> {
        let robot = |spec: PlantSpec, before: Option<&Identified>| match before.filter(|before| before.is(&spec)) {
            Some(same) => Ok(same.clone()),
            None => Identified::new(spec),
        };
        Ok(SharedParts {
            model: robot(spec.model.clone(), before.map(|before| &before.model))?,
            plant: robot(spec.plant.clone(), before.map(|before| &before.plant))?,
            quiet: robot(spec.plant.without_noise(), before.map(|before| &before.quiet))?,
            policies: SharedPart::new(spec.policies.clone())?,
        })
    }
}
