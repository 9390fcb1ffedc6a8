//! spinebench: does this learning-based continuum-robot controller really work, and where is my
//! simulator wrong?
//!
//! Rooms, lowest first; a room may import only rooms above its own line in `docs/reference/architecture.md`:
//! [`base`] value types and seeds, [`math`] numerics, [`data`] all files, [`rows`] the rows of
//! result tables, [`rod`] the Cosserat rod, [`effects`] the catalogue of missing physics,
//! [`hardware`] motors, tracker and safety, [`simulators`] simulators of motors and tracker,
//! [`plants`] robots, [`learn`] networks and Gaussian processes, [`discovery`] what a model lacks,
//! [`policies`] controllers, [`tasks`] the loops, [`calibration`] numbers of a model from
//! recordings, [`benchmark`] the blind benchmark of `discover`, [`specs`] YAML experiments,
//! [`runner`] stages, store and threads, [`report`] tables and figures.

pub mod base;
pub mod benchmark;
pub mod calibration;
pub mod data;
pub mod discovery;
pub mod effects;
pub mod hardware;
pub mod league;
pub mod learn;
pub mod math;
pub mod plants;
pub mod policies;
pub mod report;
pub mod rod;
pub mod rows;
pub mod runner;
pub mod simulators;
pub mod specs;
pub mod tasks;

/// Version of the program with the revision of its sources, as Python writes local versions (PEP
/// 440): `0.1.0+489860f7`, with `.modified` behind it where the sources were changed since. Without
/// a repository the version alone.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), env!("SPINEBENCH_REVISION"));
