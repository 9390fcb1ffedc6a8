//! The graph of stages: each a function of a part of the spec and of the results of earlier stages.
//!
//! A stage that is asked for twice, by one spec or by several, has one key and therefore stands in the graph once.

use super::codec::{CodecError, decode, encode};
use super::digest::Digest;
use super::key::{Key, key};
use super::source_digest::{self, Sources};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::any::Any;
use std::collections::{BTreeMap, HashMap};
use std::marker::PhantomData;
use std::sync::Arc;

/// What a stage can hand on: stored on disk and shared between threads.
pub trait StageResult: Serialize + DeserializeOwned + Send + Sync + 'static {}
impl<T: Serialize + DeserializeOwned + Send + Sync + 'static> StageResult for T {}

/// A result with its type forgotten; the handle of its stage remembers it.
pub(super) type AnyResult = Arc<dyn Any + Send + Sync>;

/// Why a stage has no result. It becomes the status of the rows that needed it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{stage}: {status}")]
pub struct Failure {
    /// Name of the stage that failed.
    pub stage: String,
    /// What happened, in the words of the part that failed.
    pub status: String,
}

/// A kind of stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageKind {
    /// Its name, also its folder in the store.
    pub name: &'static str,
    /// The sources that its numbers come from.
    pub sources: Sources,
    /// Rough cost of one, in milliseconds: it options work and weighs the progress bar, nothing else.
    pub cost_ms: u64,
}

/// The promise of a stage's result.
pub struct Handle<T> {
    pub(super) node: usize,
    result: PhantomData<fn() -> T>,
}

impl<T> Clone for Handle<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Handle<T> {}

impl<T> Handle<T> {
    /// The number of the stage in its graph.
    pub fn number(self) -> usize {
        self.node
    }
}

type Job = Box<dyn Fn(&Inputs) -> Result<AnyResult, String> + Send + Sync>;

/// One stage with its key and the numbers of its inputs, all smaller than its own.
pub(super) struct StageNode {
    pub(super) kind: StageKind,
    pub(super) key: Key,
    pub(super) label: String,
    pub(super) inputs: Vec<usize>,
    pub(super) job: Job,
    pub(super) encode: fn(&AnyResult) -> Result<Vec<u8>, CodecError>,
    pub(super) decode: fn(&[u8]) -> Result<AnyResult, CodecError>,
}

/// Stages in an order in which each follows its inputs.
#[derive(Default)]
pub struct Graph {
    pub(super) nodes: Vec<StageNode>,
    by_key: HashMap<Key, usize>,
    /// Digests of the code of the kinds that have been met.
    codes: BTreeMap<&'static str, Digest>,
}

impl Graph {
    /// Adds a stage, or finds the one that is already there. `params` are the spec parts that `job` reads, `inputs`
    /// the numbers of the stages whose results it asks for, `label` tells it from its like to a person.
    ///
    /// # Errors
    /// [`Failure`] when `params` cannot be written as JSON.
    pub fn stage<T: StageResult>(
        &mut self,
        kind: StageKind,
        label: impl Into<String>,
        params: &impl Serialize,
        inputs: &[usize],
        job: impl Fn(&Inputs) -> Result<T, String> + Send + Sync + 'static,
    ) -> Result<Handle<T>, Failure> {
        let keys: Vec<Key> = inputs.iter().map(|&input| self.nodes[input].key).collect();
        let code = self.codes.entry(kind.name).or_insert_with(|| source_digest::digest(kind.sources));
        let key =
            key(kind.name, code, params, &keys).map_err(|status| Failure { stage: kind.name.to_owned(), status })?;
        let node = *self.by_key.entry(key).or_insert_with(|| {
            self.nodes.push(StageNode {
                kind,
                key,
                label: label.into(),
                inputs: inputs.to_vec(),
                job: Box::new(move |given| job(given).map(|result| Arc::new(result) as AnyResult)),
                encode: |value| encode(value.downcast_ref::<T>().ok_or_else(mismatch)?),
                decode: |bytes| decode::<T>(bytes).map(|result| Arc::new(result) as AnyResult),
            });
            self.nodes.len() - 1
        });
        Ok(Handle { node, result: PhantomData })
    }

    /// Number of distinct stages.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// True without any stage.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Numbers of the stages whose results stage number `node` reads.
    pub fn inputs(&self, node: usize) -> &[usize] {
        &self.nodes[node].inputs
    }

    /// Rough cost of stage number `node`, in milliseconds.
    pub fn cost_ms(&self, node: usize) -> u64 {
        self.nodes[node].kind.cost_ms
    }

    /// The digest of the code of stage number `node`.
    pub(super) fn code(&self, node: usize) -> Digest {
        let kind = self.nodes[node].kind;
        self.codes.get(kind.name).copied().unwrap_or_else(|| source_digest::digest(kind.sources))
    }

    /// Name, label and key of stage number `node`.
    pub fn describe(&self, node: usize) -> (&'static str, &str, Key) {
        let node = &self.nodes[node];
        (node.kind.name, &node.label, node.key)
    }
}

fn mismatch() -> CodecError {
    CodecError::Unsupported("a result of another type".into())
}

/// The results that a stage asked for.
pub struct Inputs {
    pub(super) values: Vec<(usize, AnyResult)>,
}

impl Inputs {
    /// The result behind `handle`.
    ///
    /// # Errors
    /// When the stage did not name it among its inputs.
    pub fn get<T: StageResult>(&self, handle: Handle<T>) -> Result<&T, String> {
        self.values
            .iter()
            .find(|(node, _)| *node == handle.node)
            .and_then(|(_, value)| value.downcast_ref::<T>())
            .ok_or_else(|| format!("stage {} is not among the inputs", handle.node))
    }
}
