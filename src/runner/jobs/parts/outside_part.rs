//! A policy from outside beside the digest of all that it is: its options and the content of its
//! file, wherever that lies.

use crate::base::Policy;
use crate::policies::{OutsidePolicies, OutsidePolicy, PolicyOptions};
use crate::runner::graph::digest::Digest;
use crate::runner::graph::failure::Failure;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// A policy from outside, its file and their digest. Written by serde as the digest.
#[derive(Clone)]
pub(crate) struct OutsidePart {
    policy: OutsidePolicy,
    content: Arc<Vec<u8>>,
    digest: Digest,
}

impl OutsidePart {
    /// Reads the files of all policies.
    ///
    /// # Errors
    /// [`Failure`] for a file that cannot be read.
    pub(crate) fn all(
        policies: &OutsidePolicies,
    ) -> Result<BTreeMap<String, OutsidePart>, Failure> {
        policies
            .iter()
            .map(|(name, policy)| Ok((name.clone(), OutsidePart::read(policy)?)))
            .collect()
    }

    fn read(policy: &OutsidePolicy) -> Result<OutsidePart, Failure> {
        let failed = |status: String| Failure { stage: "policy".into(), status };
        let file = policy.file();
        let content =
            std::fs::read(file).map_err(|error| failed(format!("{}: {error}", file.display())))?;
        let nameless = policy.clone().with_file(PathBuf::new());
        let mut bytes = serde_json::to_vec(&nameless).map_err(|error| failed(error.to_string()))?;
        bytes.extend(&content);
        Ok(OutsidePart {
            policy: policy.clone(),
            content: Arc::new(content),
            digest: Digest::of(&bytes),
        })
    }

    /// Whether it takes samples of the robot before its trials.
    pub(crate) fn takes_samples(&self) -> bool {
        self.policy.samples() > 0
    }

    /// The policy for a robot with so many tendons.
    ///
    /// # Errors
    /// What is not as it should be, in words.
    pub(crate) fn build(
        &self,
        tendons: usize,
        options: &PolicyOptions,
    ) -> Result<Box<dyn Policy>, String> {
        self.policy.build(&self.content, tendons, options)
    }
}

impl Serialize for OutsidePart {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.digest.serialize(serializer)
    }
}
