//! The stages of an experiment: what each computes and which parts of the spec and earlier results it reads.
//!
//! A stage's parameters are everything of the spec that its job touches, and nothing else: they are its key.

mod data;
mod discovery;
mod identified;
mod learning;
mod trials;

pub(super) use discovery::BlindStages;

use super::code;
use super::digest::Digest;
use super::graph::{Failure, Graph, Handle};
use crate::base::{Point3, Seed};
use crate::specs::Experiment;
use crate::tasks::{GpPool, Samples};
use identified::Identified;
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
    model: Identified,
    plant: Identified,
    seed: Seed,
    repetition: u64,
    known: Known,
}

/// Stages that many others ask for, once they have been added.
#[derive(Default)]
struct Known {
    explored: Option<Handle<Samples>>,
    replayed: Option<Handle<Samples>>,
    gp_pool: Option<Handle<GpPool>>,
    targets: Option<Handle<data::Targets>>,
    path: Option<Handle<Vec<Point3>>>,
}

impl<'a> Stages<'a> {
    /// For repetition number `repetition` of `spec`. Its seed depends on the spec's seed and its number only, so that
    /// experiments that share settings share stages.
    ///
    /// # Errors
    /// [`Failure`] for a robot that cannot be written into a key.
    pub fn new(graph: &'a mut Graph, spec: &'a Experiment, repetition: u64) -> Result<Stages<'a>, Failure> {
        let seed = Seed(spec.seed).child("repetition").index(repetition);
        let (model, plant) = (Identified::new(spec.model.clone())?, Identified::new(spec.plant.clone())?);
        Ok(Stages { graph, spec, model, plant, seed, repetition, known: Known::default() })
    }

    fn label(&self, what: &str) -> String {
        format!("{what} (seed {})", self.repetition)
    }

    fn step_s(&self) -> f64 {
        1.0 / self.spec.control_hz
    }
}

/// What adding a stage yields.
type Added<T> = Result<Handle<T>, Failure>;

/// An error of a lower room as the status of a stage.
fn status(error: impl std::fmt::Display) -> String {
    error.to_string()
}
