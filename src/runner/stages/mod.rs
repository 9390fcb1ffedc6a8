//! The stages of an experiment: what each computes and which parts of the spec and earlier results it reads.
//!
//! A stage's parameters are everything of the spec that its job touches, and nothing else: they are its key.

mod data;
mod discovery;
mod learning;
mod trials;

pub(super) use discovery::BlindStages;

use super::code;
use super::digest::Digest;
use super::graph::{Failure, Graph};
use crate::base::Seed;
use crate::specs::Experiment;
use std::collections::BTreeMap;

/// The digest of the present code of each kind of stage, by its name.
pub fn codes() -> BTreeMap<&'static str, Digest> {
    let kinds = [&data::KINDS[..], &learning::KINDS, &trials::KINDS, &discovery::KINDS];
    kinds.into_iter().flatten().map(|kind| (kind.name, code::digest(kind.sources))).collect()
}

/// Adds the stages of one repetition of an experiment to a graph.
pub struct Stages<'a> {
    graph: &'a mut Graph,
    spec: &'a Experiment,
    seed: Seed,
    repetition: u64,
}

impl<'a> Stages<'a> {
    /// For repetition number `repetition` of `spec`. Its seed depends on the spec's seed and its number only, so that
    /// experiments that share settings share stages.
    pub fn new(graph: &'a mut Graph, spec: &'a Experiment, repetition: u64) -> Stages<'a> {
        let seed = Seed(spec.seed).child("repetition").index(repetition);
        Stages { graph, spec, seed, repetition }
    }

    fn label(&self, what: &str) -> String {
        format!("{what} (seed {})", self.repetition)
    }

    fn step_s(&self) -> f64 {
        1.0 / self.spec.control_hz
    }
}

/// What adding a stage yields.
type Added<T> = Result<super::graph::Handle<T>, Failure>;

/// An error of a lower room as the status of a stage.
fn status(error: impl std::fmt::Display) -> String {
    error.to_string()
}
