//! The graph of stages: each a function of parameters from the spec and of the results of earlier
//! stages.
//!
//! A stage that is added twice, by one spec or by several, has one key and therefore exists in the
//! graph once.

mod codec;
pub(super) mod digest;
pub(super) mod failure;
pub(super) mod key;
pub(super) mod source_digest;
pub(super) mod stage;
pub(super) mod timing;

use codec::{CodecError, decode, encode};
use digest::Digest;
pub(super) use failure::Failure;
use key::{Key, key};
use serde::Serialize;
use stage::{AnyResult, InputResults, Stage, StageInputs, StageResult};
pub(super) use stage::{Handle, StageKind};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

type AnyJob = Box<dyn Fn(&InputResults) -> Result<AnyResult, String> + Send + Sync>;

/// One stage with its key and the numbers of its inputs, all smaller than its own.
pub(super) struct StageNode {
    pub(super) kind: StageKind,
    /// Rough cost, milliseconds: that of its kind times its size.
    pub(super) cost_ms: u64,
    pub(super) key: Key,
    pub(super) label: String,
    pub(super) inputs: Vec<usize>,
    pub(super) job: AnyJob,
    pub(super) encode: fn(&AnyResult) -> Result<Vec<u8>, CodecError>,
    pub(super) decode: fn(&[u8]) -> Result<AnyResult, CodecError>,
}

/// Stages in an order in which each follows its inputs.
#[derive(Default)]
pub struct Graph {
    pub(super) nodes: Vec<StageNode>,
    by_key: HashMap<Key, usize>,
    /// Sizes of the stages that are added next, by kind; those of other kinds have size 1.
    sizes: BTreeMap<&'static str, f64>,
    /// Digests of the code of the kinds that have been met.
    codes: BTreeMap<&'static str, Digest>,
}

impl Graph {
    /// Sizes of the stages that are added from now on, by kind, beside those for which the cost of
    /// a kind is given.
    pub(super) fn set_sizes(&mut self, sizes: BTreeMap<&'static str, f64>) {
        self.sizes = sizes;
    }

    /// The same for one kind.
    pub(super) fn set_size(&mut self, kind: &'static str, size: f64) {
        self.sizes.insert(kind, size);
    }

    /// Adds a stage, or finds the one that is already there. `label` distinguishes it from others
    /// of its kind for a person.
    ///
    /// # Errors
    /// [`Failure`] when `params` cannot be written as JSON.
    pub fn stage<P, I, T>(
        &mut self,
        stage: &Stage<P, I, T>,
        label: impl Into<String>,
        params: P,
        inputs: I,
    ) -> Result<Handle<T>, Failure>
    where
        P: Serialize + Send + Sync + 'static,
        I: StageInputs,
        T: StageResult,
    {
        let (kind, job) = (stage.kind, stage.job);
        let mut numbers = Vec::new();
        inputs.add_numbers(&mut numbers);
        let keys: Vec<Key> = numbers.iter().map(|&input| self.nodes[input].key).collect();
        let code =
            self.codes.entry(kind.name).or_insert_with(|| source_digest::of_module(kind.module));
        let key = key(kind.name, code, &params, &keys)
            .map_err(|status| Failure { stage: kind.name.to_owned(), status })?;
        let size = self.sizes.get(kind.name).copied().unwrap_or(1.0);
        let node = *self.by_key.entry(key).or_insert_with(|| {
            self.nodes.push(StageNode {
                kind,
                cost_ms: (kind.cost_ms as f64 * size).ceil() as u64,
                key,
                label: label.into(),
                inputs: numbers,
                job: Box::new(move |results| {
                    job(&params, inputs.read(results)?).map(|result| Arc::new(result) as AnyResult)
                }),
                encode: |value| encode(value.downcast_ref::<T>().ok_or_else(mismatch)?),
                decode: |bytes| decode::<T>(bytes).map(|result| Arc::new(result) as AnyResult),
            });
            self.nodes.len() - 1
        });
        Ok(Handle::new(node))
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
        self.nodes[node].cost_ms
    }

    /// The digest of the code of stage number `node`.
    pub(super) fn code(&self, node: usize) -> Digest {
        let kind = self.nodes[node].kind;
        self.codes.get(kind.name).copied().unwrap_or_else(|| source_digest::of_module(kind.module))
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
