//! The recording as samples: what is fitted, what is held out, and what is known of each sample beforehand.

pub(crate) mod base_markers;
pub(crate) mod covariates;
pub(crate) mod holdout;
pub(crate) mod samples;
pub(crate) mod validate;
