//! Stages, cache, threads, progress.

pub mod codec;
