//! What a stage is: a function of keyed parameters and of the results of earlier stages, and of
//! nothing else.
//!
//! The function is a plain `fn`: it can capture nothing, and it receives exactly the parameters
//! that are in the stage's key and the results that are named as its inputs. An input that is not
//! named does not compile.

use serde::{Serialize, de::DeserializeOwned};
use std::any::Any;
use std::marker::PhantomData;
use std::sync::Arc;

/// A result of a stage: stored on disk and shared between threads.
pub trait StageResult: Serialize + DeserializeOwned + Send + Sync + 'static {}
impl<T: Serialize + DeserializeOwned + Send + Sync + 'static> StageResult for T {}

/// A kind of stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageKind {
    /// Its name, also its folder in the store.
    pub name: &'static str,
    /// The module of its job, as `module_path!()` names it: what the job depends on is derived from
    /// its imports.
    pub module: &'static str,
    /// Rough cost of one of the size that it has in the paper's experiments, in milliseconds: it
    /// orders work and weighs the progress bar, nothing else.
    pub cost_ms: u64,
}

/// The job of a stage: its result from its parameters and the results of its inputs; an error is a
/// status.
pub type Job<P, I, T> = fn(&P, <I as StageInputs>::Results<'_>) -> Result<T, String>;

/// A kind of stage with its job.
pub struct Stage<P, I: StageInputs, T> {
    /// Name, module and cost.
    pub kind: StageKind,
    /// What it computes.
    pub job: Job<P, I, T>,
}

/// The promise of a stage's result.
pub struct Handle<T> {
    pub(crate) node: usize,
    result: PhantomData<fn() -> T>,
}

impl<T> Clone for Handle<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Handle<T> {}

impl<T> Handle<T> {
    /// The handle of the stage with this number, which yields a `T`.
    pub(crate) fn new(node: usize) -> Handle<T> {
        Handle { node, result: PhantomData }
    }

    /// The number of the stage in its graph.
    pub fn number(self) -> usize {
        self.node
    }
}

/// A result with its type forgotten; the handle of its stage remembers it.
pub(crate) type AnyResult = Arc<dyn Any + Send + Sync>;

/// The results of a stage's inputs, by the number of their stage.
pub struct InputResults {
    pub(crate) results: Vec<(usize, AnyResult)>,
}

/// Handles of the stages whose results a job reads: one, an optional one, a list, or a tuple of
/// these.
pub trait StageInputs: Send + Sync + 'static {
    /// What the job receives.
    type Results<'a>;

    /// Adds the numbers of the stages.
    fn add_numbers(&self, numbers: &mut Vec<usize>);

    /// Finds the results.
    ///
    /// # Errors
    /// When the executor did not provide a result: a defect of the executor.
    fn read<'a>(&self, results: &'a InputResults) -> Result<Self::Results<'a>, String>;
}

impl<T: StageResult> StageInputs for Handle<T> {
    type Results<'a> = &'a T;

    fn add_numbers(&self, numbers: &mut Vec<usize>) {
        numbers.push(self.node);
    }

    fn read<'a>(&self, results: &'a InputResults) -> Result<&'a T, String> {
        let result = results.results.iter().find(|(node, _)| *node == self.node);
        let result = result.and_then(|(_, result)| result.downcast_ref::<T>());
        result.ok_or_else(|| format!("the result of stage {} was not provided", self.node))
    }
}

impl<I: StageInputs> StageInputs for Option<I> {
    type Results<'a> = Option<I::Results<'a>>;

    fn add_numbers(&self, numbers: &mut Vec<usize>) {
        self.iter().for_each(|input| input.add_numbers(numbers));
    }

    fn read<'a>(&self, results: &'a InputResults) -> Result<Self::Results<'a>, String> {
        self.as_ref().map(|input| input.read(results)).transpose()
    }
}

impl<I: StageInputs> StageInputs for Vec<I> {
    type Results<'a> = Vec<I::Results<'a>>;

    fn add_numbers(&self, numbers: &mut Vec<usize>) {
        self.iter().for_each(|input| input.add_numbers(numbers));
    }

    fn read<'a>(&self, results: &'a InputResults) -> Result<Self::Results<'a>, String> {
        self.iter().map(|input| input.read(results)).collect()
    }
}

macro_rules! tuples {
    ($(($($input:ident)*))*) => {
        $(#[allow(non_snake_case, unused_variables, clippy::unused_unit)]
        impl<$($input: StageInputs),*> StageInputs for ($($input,)*) {
            type Results<'a> = ($($input::Results<'a>,)*);

            fn add_numbers(&self, numbers: &mut Vec<usize>) {
                let ($($input,)*) = self;
                $($input.add_numbers(numbers);)*
            }

            fn read<'a>(&self, results: &'a InputResults) -> Result<Self::Results<'a>, String> {
                let ($($input,)*) = self;
                Ok(($($input.read(results)?,)*))
            }
        })*
    };
}
tuples! { () (A) (A B) (A B C) (A B C D) }
