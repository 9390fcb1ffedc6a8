//! The stages of an experiment: which parts of the spec and which earlier results each of them
//! reads. What they compute is in `jobs`.

mod data;
mod discovery;
mod learning;
mod repair;
mod shared;
mod sizes;
mod trials;

pub(super) use discovery::BlindStages;
pub(super) use repair::{RepairCampaign, RepairStages, RepairVariant};
pub(super) use shared::SharedParts;

use super::graph::Graph;
use super::graph::digest::Digest;
use super::graph::failure::Failure;
use super::graph::source_digest;
use super::graph::stage::{Handle, StageKind};
use super::jobs;
use crate::base::Seed;
use crate::policies::{NetworkDescription, TrainingData, networks};
use crate::rows::cell::CellLabel;
use crate::specs::{Experiment, Training};
use std::any::Any;
use std::collections::{BTreeMap, HashMap};

/// The digest of the present code of each kind of stage, by its name.
pub fn codes() -> BTreeMap<&'static str, Digest> {
    kinds().map(|kind| (kind.name, source_digest::of_module(kind.module))).collect()
}

/// Every kind of stage: those with a job of their own, and the training of the networks that
/// policies describe.
fn kinds() -> impl Iterator<Item = StageKind> {
    jobs::kinds().into_iter().chain(networks().into_iter().map(learning::kind))
}

/// What the results of a kind of stage depend on besides its parameters and inputs.
pub struct StageDependencies {
    /// Name of the kind; `bench` for what a robot on a bench adds to its own digest.
    pub name: &'static str,
    /// The module of its job.
    pub module: &'static str,
    /// Sources, by their paths below `src/`.
    pub sources: Vec<&'static str>,
    /// Packages, each with version and checksum.
    pub packages: &'static [&'static str],
}

/// The dependencies of every kind of stage and of robots on a bench.
pub fn stage_dependencies() -> Vec<StageDependencies> {
    let kinds = kinds().map(|kind| (kind.name, kind.module));
    let all = kinds.chain([(source_digest::BENCH, source_digest::BENCH)]);
    all.map(|(name, module)| {
        let (sources, packages) = source_digest::dependencies(module);
        StageDependencies { name, module, sources, packages }
    })
    .collect()
}

/// Adds the stages of one repetition of an experiment to a graph.
pub(super) struct Stages<'a> {
    graph: &'a mut Graph,
    spec: &'a Experiment,
    parts: &'a SharedParts,
    seed: Seed,
    repetition: u64,
    /// Stages of this repetition that were added before: asking again costs no key.
    added: HashMap<StageQuery, Box<dyn Any>>,
}

/// What one of several like stages of a repetition was asked for: its kind, where the networks
/// behind it stop, its size.
type StageQuery = (&'static str, Option<[Option<u64>; 4]>, usize);

impl<'a> Stages<'a> {
    /// For repetition number `repetition` of `spec`. Its seed depends on the spec's seed and its
    /// number only, so that experiments that share settings share stages.
    pub(super) fn new(
        graph: &'a mut Graph,
        spec: &'a Experiment,
        parts: &'a SharedParts,
        repetition: u64,
    ) -> Stages<'a> {
        let seed = Seed(spec.seed).child("repetition").index(repetition);
        let trained =
            networks().into_iter().filter(|network| network.data != TrainingData::Randomised);
        graph.set_sizes(sizes::sizes(spec, trained.map(|network| network.stage)));
        Stages { graph, spec, parts, seed, repetition, added: HashMap::new() }
    }

    /// The stage that was added for `query` before, or the one that `add` adds now.
    fn once<T: 'static>(
        &mut self,
        query: StageQuery,
        add: impl FnOnce(&mut Self) -> Added<T>,
    ) -> Added<T> {
        if let Some(handle) =
            self.added.get(&query).and_then(|added| added.downcast_ref::<Handle<T>>())
        {
            return Ok(*handle);
        }
        let handle = add(self)?;
        self.added.insert(query, Box::new(handle));
        Ok(handle)
    }

    fn label(&self, what: &str) -> String {
        format!("{what} (seed {})", self.repetition)
    }

    fn step_s(&self) -> f64 {
        1.0 / self.spec.control_hz
    }
}

/// A kind of training as part of what is asked for.
fn stops(training: &Training) -> Option<[Option<u64>; 4]> {
    let Training { forward_mae_m, inverse_mae_m, inverse_b_mae_m, pi_real_mae_m } = *training;
    Some(
        [forward_mae_m, inverse_mae_m, inverse_b_mae_m, pi_real_mae_m]
            .map(|stop_m| stop_m.map(f64::to_bits)),
    )
}

/// What adding a stage yields.
type Added<T> = Result<Handle<T>, Failure>;

/// How much data a network of a cell depends on: real points, points of the error model, or 0 for
/// simulated data.
pub(super) fn points_of(network: &NetworkDescription, cell: &CellLabel) -> usize {
    match network.data {
        TrainingData::Simulated | TrainingData::Randomised => 0,
        TrainingData::Real => cell.real_points as usize,
        TrainingData::Generated => cell.gp_points as usize,
    }
}
