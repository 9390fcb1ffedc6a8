//! The recording as samples: training part, held-out part, and covariates of each sample.

pub(crate) mod base_markers;
pub(crate) mod blocks;
pub(crate) mod covariates;
pub(crate) mod holdout;
pub(crate) mod samples;
pub(crate) mod validate;
