//! spinebench: does this learning-based continuum-robot controller really work, and where is my simulator wrong?
//!
//! Rooms, lowest first; a room may import only rooms above its own line in `docs/architecture.md`:
//! [`base`] value types and seeds, [`math`] numerics, [`data`] everything on disk, [`rod`] the Cosserat rod,
//! [`effects`] the catalogue of missing physics, [`hardware`] motors, tracker and safety, [`plants`] things that move, [`learn`] networks and Gaussian
//! processes, [`discovery`] what a model lacks, [`policies`] controllers, [`tasks`] the loops, [`specs`] YAML experiments, [`runner`] stages,
//! cache and threads, [`report`] tables and figures.

pub mod base;
pub mod math;

pub mod data;
pub mod rod;

pub mod effects;
pub mod hardware;

pub mod plants;

pub mod discovery;
pub mod learn;
pub mod policies;

pub mod tasks;

pub mod specs;

pub mod report;
pub mod runner;
