//! A part of a spec that many stages read: shared by their jobs, and in the stages' keys as one
//! digest, so that a sweep of many points neither copies nor writes out a robot for every stage.

use crate::runner::graph::digest::Digest;
use crate::runner::graph::failure::Failure;
use serde::{Serialize, Serializer};
use std::ops::Deref;
use std::sync::Arc;

/// A part of a spec with the digest of its JSON, which is how it serialises.
pub(crate) struct SharedPart<T>(Arc<(T, Digest)>);

impl<T: Serialize> SharedPart<T> {
    /// The part with its digest.
    ///
    /// # Errors
    /// [`Failure`] for a part that cannot be written as JSON.
    pub(crate) fn new(value: T) -> Result<SharedPart<T>, Failure> {
        let failed =
            |error: serde_json::Error| Failure { stage: "spec".into(), status: error.to_string() };
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
